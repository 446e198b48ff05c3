#include "inhabit/reconstruct/reconstruct.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "inhabit/error.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/reconstruct/scene_points.h"
#include "inhabit/reconstruct/visible_body.h"
#include "inhabit/reconstruct/world_motion.h"
#include "inhabit/scene/point_rows.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

constexpr int64_t kScaleFrames = 200;                    // that tell the depth's scale, at most
constexpr int64_t kObjectViews = 6;                      // of each object, at most
constexpr int kBesidePerson = 3, kBesideObject = 2;      // pixels around masks that are nobody's
constexpr double kSeenThrough = 0.06;                    // metres and part of the distance
constexpr double kFloorReach = 0.3, kFloorLayer = 0.05;  // metres
constexpr double kObjectLayer = 0.06;                    // metres from an object within which points are its own
constexpr double kSmallSpread = 0.3;                     // metres of depth: too few to tell scale from offset

/// At most `most` of `all` items, evenly taken.
std::vector<size_t> evenly(size_t all, int64_t most) {
  const size_t count = std::min(all, static_cast<size_t>(most));
  std::vector<size_t> out;
  out.reserve(count);
  for (size_t i = 0; i < count; ++i) out.push_back(count > 1 ? i * (all - 1) / (count - 1) : all / 2);
  return out;
}

/// What all frames of a camera that stands see of objects, as one view: the mean of each pixel's depths, where they are
/// sure and nobody stands, so that errors that differ from frame to frame fade.
class StandingView {
 public:
  explicit StandingView(size_t objects) : objects_(objects) {}

  /// @param masks (objects) (height, width) bool, undefined where the frame has none
  void add(const View& view, const std::vector<Tensor>& masks) {
    const Tensor known = view.depth.gt(0).logical_and(dilated(view.person, kBesideObject).logical_not());
    const auto count = [&](Tensor& sum, const Tensor& what) { sum = sum.defined() ? sum + what : what.clone(); };
    count(sum_, torch::where(known, view.depth, torch::zeros_like(view.depth)));
    count(frames_, known.to(torch::kFloat32));
    for (size_t i = 0; i < masks.size(); ++i) {
      if (!masks[i].defined()) continue;
      count(objects_[i].masked, known.logical_and(masks[i]).to(torch::kFloat32));
      count(objects_[i].frames, known.to(torch::kFloat32));
    }
  }
  View view(int64_t frame) const {
    return {frame, sum_ / frames_.clamp_min(1), torch::zeros(sum_.sizes(), torch::kBool)};
  }
  /// Pixels that are the object's in most of the frames that have a mask of it and know their depth.
  Tensor mask(size_t object) const { return objects_[object].masked.gt(0.5 * objects_[object].frames); }

 private:
  struct Counts {
    Tensor masked, frames;
  };
  Tensor sum_, frames_;
  std::vector<Counts> objects_;
};

class Reconstruction {
 public:
  Reconstruction(const Inputs& inputs, const Options& options)
      : inputs_(inputs),
        options_(options),
        source_(in_world(inputs.motion, inputs.camera, options.name)),
        standard_(retarget(source_, options.name)),
        body_(standard_, options.body != nullptr ? *options.body : builtin_body()),
        standing_(inputs.objects.size()) {
    check();
    choose_keys();
    choose_views();
  }

  Result run(const inbetween::SceneInbetweener& inbetweener) {
    Result out;
    out.before = standard_;
    out.depth = find_scale();
    if (out.depth.floor == 0 && out.depth.spread < kSmallSpread) {
      char text[160];
      std::snprintf(text, sizeof text,
                    "no floor is seen, and the person's distance varies by %.2f m only: that tells scale and offset of "
                    "the depth apart poorly",
                    out.depth.spread);
      out.notes.emplace_back(text);
    }
    read_depth(out.depth.scale);
    build_scene(out);
    const KeyRoots roots =
        optimise_key_roots(body_, standard_.betas, standard_.rate, keys_, clouds_, out.scene, options_.roots);
    out.contacts = roots.contacts;
    out.moved_keys = keys_;
    for (const Vector3d& m : roots.moved) out.moved += m.norm() / static_cast<double>(roots.moved.size());
    out.keys_moved = with_roots_moved(standard_, keys_, roots.moved);
    fill(inbetweener, with_roots_moved(source_, keys_, roots.moved), out);
    return out;
  }

 private:
  /// What does not fit together is said before anything is read.
  void check() const {
    if (inputs_.depth.frames.empty()) throw Error(inputs_.depth.name, "holds no depth maps");
    if (options_.key_step < 1 || options_.keep_every < 1) throw Error("keys", "want to be one frame apart or more");
    if (!(options_.uncertainty > 0 && options_.jump > 0 && options_.cell > 0.001))
      throw Error("depth", "uncertainty, jumps and the scene's cells want to be over 0");
    if (source_.frames() < 2) throw Error(options_.name, "has no two frames");
    const int64_t last = inputs_.depth.frames.back();
    if (last >= source_.frames())
      throw Error(inputs_.depth.name, "the last depth map is of frame " + std::to_string(last) + ", but " +
                                          options_.name + " has " + std::to_string(source_.frames()) + " frames");
    for (const int64_t frame : inputs_.depth.frames)
      if (inputs_.masks.index_of(frame) < 0)
        throw Error(inputs_.masks.name,
                    "there is no mask of frame " + std::to_string(frame) + ", of which there is a depth map");
    for (const ObjectInput& object : inputs_.objects)
      if (object.masks.every_frame && inputs_.camera.moves())
        throw Error(object.masks.name, "is one mask for all frames, but the camera moves");
  }

  /// Key frames at 30 a second divided by the step, and the last frame.
  void choose_keys() {
    const double step = static_cast<double>(options_.key_step) * source_.rate / 30;
    const int64_t last = source_.frames() - 1;
    for (int64_t k = 0;; ++k) {
      const auto frame = static_cast<int64_t>(std::round(step * static_cast<double>(k)));
      if (frame >= last) break;
      if (keys_.empty() || frame > keys_.back()) keys_.push_back(frame);
    }
    if (keys_.size() > 1 && static_cast<double>(last - keys_.back()) < 0.5 * step) keys_.pop_back();
    keys_.push_back(last);
    clouds_.resize(keys_.size());
  }

  /// Frames that are kept whole: what objects are seen in, and what points are checked against.
  void choose_views() {
    const std::vector<int64_t>& frames = inputs_.depth.frames;
    for (const size_t i : evenly(frames.size(), kObjectViews)) view_frames_.insert(frames[i]);
    for (const ObjectInput& object : inputs_.objects) {
      std::vector<int64_t> own;
      for (const int64_t frame : frames)
        if (object.masks.index_of(frame) >= 0) own.push_back(frame);
      if (own.empty()) throw Error(object.masks.name, "no mask is of a frame with a depth map");
      object_frames_.emplace_back();
      if (!inputs_.camera.moves()) continue;  // all frames are one view
      for (const size_t i : evenly(own.size(), kObjectViews)) object_frames_.back().insert(own[i]);
      view_frames_.insert(object_frames_.back().begin(), object_frames_.back().end());
    }
  }

  Tensor person_at(int64_t frame) const {
    return inputs_.masks.read(static_cast<size_t>(inputs_.masks.index_of(frame)));
  }

  DepthAlignment find_scale() {
    std::vector<SeenBody> seen;
    const std::vector<size_t> chosen = evenly(inputs_.depth.frames.size(), kScaleFrames);
    feet_ = feet_height(body_, 1 + source_.frames() / kScaleFrames);
    for (const size_t i : chosen) {
      const int64_t frame = inputs_.depth.frames[i];
      seen.push_back(seen_body(body_, combined(inputs_.depth.read(i), options_.uncertainty), person_at(frame),
                               inputs_.camera, frame, feet_));
      if (!options_.floor_scale) seen.back().floor.clear();
      said(static_cast<int64_t>(seen.size()), chosen.size());
    }
    read_ = static_cast<int64_t>(chosen.size());
    return align_depth(seen, inputs_.depth.name);
  }

  void said(int64_t done, size_t scale_frames) const {
    if (options_.progress) options_.progress(done, static_cast<int64_t>(scale_frames + inputs_.depth.frames.size()));
  }

  /// Points of the scene, views, and the person's points at key frames.
  void read_depth(const DepthScale& scale) {
    const int64_t before = read_;
    for (size_t i = 0; i < inputs_.depth.frames.size(); ++i) {
      View view;
      view.frame = inputs_.depth.frames[i];
      view.depth = metric_depth(combined(inputs_.depth.read(i), options_.uncertainty), scale, options_.jump);
      view.person = person_at(view.frame);
      Tensor rest = dilated(view.person, kBesidePerson).logical_not();
      std::vector<Tensor> masks;
      for (const ObjectInput& object : inputs_.objects) {
        masks.emplace_back();
        const int64_t k = object.masks.index_of(view.frame);
        if (k < 0) continue;
        masks.back() = object.masks.read(static_cast<size_t>(k));
        rest = rest.logical_and(dilated(masks.back(), kBesideObject).logical_not());
      }
      if (!inputs_.camera.moves() && !masks.empty()) standing_.add(view, masks);
      grid_.add(view, rest, inputs_.camera, inputs_.depth.name);
      const auto key = std::lower_bound(keys_.begin(), keys_.end(), view.frame);
      if (key != keys_.end() && *key == view.frame)
        clouds_[static_cast<size_t>(key - keys_.begin())] = seen_cloud(body_, view, inputs_.camera);
      if (view_frames_.count(view.frame) != 0) views_.push_back(std::move(view));
      said(++read_, static_cast<size_t>(before));
    }
  }

  void build_scene(Result& out) {
    std::vector<Vector3d> points = without_seen_through(grid_.points(inputs_.depth.frames.size() > 3 ? 2 : 1), views_,
                                                        inputs_.camera, kSeenThrough);
    out.floor = floor_height(points, feet_, kFloorReach);
    const bool moves = inputs_.camera.moves();
    const View whole = moves || inputs_.objects.empty() ? View() : standing_.view(inputs_.depth.frames.front());
    for (size_t i = 0; i < inputs_.objects.size(); ++i) {
      const ObjectInput& object = inputs_.objects[i];
      ObjectViews seen;
      if (moves) {
        for (const View& view : views_) {
          if (object_frames_[i].count(view.frame) == 0) continue;
          seen.views.push_back(&view);
          seen.masks.push_back(object.masks.read(static_cast<size_t>(object.masks.index_of(view.frame))));
        }
      } else {
        seen = {{&whole}, {standing_.mask(i)}};
      }
      out.objects.push_back(place_object(object.name, object.meshes, seen, inputs_.camera, out.floor));
      out.scene.meshes.insert(out.scene.meshes.end(), out.objects.back().meshes.begin(),
                              out.objects.back().meshes.end());
    }
    points = without_known(points, out);
    std::vector<Vector3d> all = points;  // the floor goes under everybody and everything
    const Tensor path = standard_.root_path();
    for (int64_t t = 0; t < path.size(0); ++t)
      all.emplace_back(path[t][0].item<double>(), path[t][1].item<double>(), path[t][2].item<double>());
    out.scene.name = "reconstruction";
    out.scene.meshes.push_back(floor_mesh(all, out.floor));
    if (!points.empty()) out.scene.points = point_rows(points);
  }

  /// Points that are neither the floor's nor an object's.
  std::vector<Vector3d> without_known(const std::vector<Vector3d>& points, const Result& out) const {
    std::vector<Vector3d> above;
    for (const Vector3d& p : points)
      if (p.y() > out.floor + kFloorLayer) above.push_back(p);
    if (out.scene.meshes.empty() || above.empty()) return above;
    const Tensor away = SceneQuery(out.scene).closest(point_rows(above)).distances;
    const auto a = away.accessor<float, 1>();
    std::vector<Vector3d> kept;
    for (size_t i = 0; i < above.size(); ++i)
      if (a[static_cast<int64_t>(i)] > kObjectLayer) kept.push_back(above[i]);
    return kept;
  }

  /// Motion between every few key frames.
  void fill(const inbetween::SceneInbetweener& inbetweener, const Clip& moved, Result& out) const {
    inbetween::Options filling;
    for (size_t k = 0; k < keys_.size(); k += static_cast<size_t>(options_.keep_every))
      filling.keys.push_back(keys_[k]);
    if (filling.keys.back() != keys_.back()) filling.keys.push_back(keys_.back());
    filling.steps = options_.steps;
    filling.seed = options_.seed;
    filling.name = options_.name;
    filling.standard = options_.standard;
    filling.collisions = options_.collisions;
    inbetween::Result filled = inbetweener.run(moved, out.scene, filling);
    out.motion = std::move(filled.motion);
    out.on_source = std::move(filled.on_source);
    out.keys = std::move(filled.keys);
    out.key_poses = std::move(filled.key_poses);
    out.collides = filled.collides;
    out.immersions = std::move(filled.immersions);
  }

  const Inputs& inputs_;
  const Options& options_;
  Clip source_, standard_;
  BodyInFrames body_;
  std::vector<int64_t> keys_;
  std::vector<refine::DepthCloud> clouds_;  ///< (keys)
  std::set<int64_t> view_frames_;
  std::vector<std::set<int64_t>> object_frames_;  ///< (objects) of a camera that moves
  std::vector<View> views_;
  StandingView standing_;
  PointGrid grid_{options_.cell};
  int64_t read_ = 0;
  double feet_ = 0;  ///< metres, height of the floor by the estimate's feet
};

}  // namespace

Result run(const Inputs& inputs, const inbetween::SceneInbetweener& inbetweener, const Options& options) {
  const torch::NoGradGuard no_gradients;
  return Reconstruction(inputs, options).run(inbetweener);
}

}  // namespace inhabit::reconstruct
