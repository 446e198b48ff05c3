#include "inhabit/inbetween/sample.h"

#include <algorithm>

#include "inhabit/body/body_model.h"
#include "inhabit/body/fit.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/data/cache.h"
#include "inhabit/data/native.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/way_around.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/scene/basis_points.h"
#include "inhabit/scene/occupancy.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr size_t kScenesKept = 256, kClipsKept = 4096;

/// The built-in body cut down to its anchors.
const BodyModel& anchor_body() {
  static const BodyModel body = [] {
    BodyModel out = builtin_body();
    out.template_vertices = out.template_vertices.index_select(0, out.anchors);
    out.shape_dirs = out.shape_dirs.index_select(0, out.anchors);
    out.skin_weights = out.skin_weights.index_select(0, out.anchors);
    return out;
  }();
  return body;
}

/// Bits of a grid of 1 and -1, and back.
Tensor packed(const Tensor& grid) {
  const Tensor bits = (grid > 0).to(torch::kUInt8).view({-1, 8});
  return (bits * torch::tensor({1, 2, 4, 8, 16, 32, 64, 128}, torch::kUInt8)).sum(1, false, torch::kUInt8);
}
Tensor unpacked(const Tensor& bytes, torch::IntArrayRef shape) {
  const Tensor bits = bytes.unsqueeze(1).bitwise_and(torch::tensor({1, 2, 4, 8, 16, 32, 64, 128}, torch::kUInt8));
  return ((bits > 0).to(torch::kFloat32) * 2 - 1).view(shape);
}

struct Recording {
  Clip clip;
  Tensor offsets;                     // (T, 64, 3) half, world axes
  Tensor body_shape;                  // (7)
  std::vector<Tensor> grids, floors;  // packed, of each window
};

struct Place {
  int32_t set, clip, start;
};

struct Room {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const SceneQuery> query;
};

}  // namespace

Tensor body_betas(const Clip& clip) {
  return clip.betas.defined() ? clip.betas : fit_shape(builtin_body(), clip.joints);
}

Tensor anchor_positions(const Clip& clip) {
  const torch::NoGradGuard no_gradients;
  const BodyModel& body = anchor_body();
  const Tensor betas = body_betas(clip);
  const Tensor trans = clip.root_path() - shaped_skeleton(body, betas).offsets[0];
  return skin(body, betas, axis_angle_to_matrix(clip.rotations), trans);
}

Tensor scene_occupancy(const SceneQuery& scene, const Tensor& root, double yaw) {
  const Eigen::Vector3d center(root[0].item<double>(), root[1].item<double>(), root[2].item<double>());
  return occupancy_grid(scene.solid(), center, yaw).permute({1, 0, 2}).contiguous();
}

struct Data::Impl {
  int64_t frames = 0, stride = 0;
  std::vector<Dataset> sets;
  std::vector<Place> places;
  mutable RecentCache<std::shared_ptr<const Recording>> recordings{kClipsKept,
                                                                   [this](const std::string& k) { return record(k); }};
  mutable RecentCache<Room> rooms{kScenesKept, [this](const std::string& k) { return read_room(k); }};

  // Keys are "set/item", where an item is a clip's number or a scene's name.
  static std::string key(int32_t set, const std::string& item) { return std::to_string(set) + "/" + item; }
  std::pair<const Dataset&, std::string> parts(const std::string& key) const {
    const size_t slash = key.find('/');
    return {sets[std::stoul(key.substr(0, slash))], key.substr(slash + 1)};
  }
  Room read_room(const std::string& k) const {
    const auto [set, name] = parts(k);
    auto scene = std::make_shared<Scene>(load_scene(set, name));
    return {scene, std::make_shared<SceneQuery>(*scene)};
  }
  Room room(const Place& place) const { return rooms.get(key(place.set, sets[place.set].clips[place.clip].scene)); }
  std::shared_ptr<const Recording> record(const std::string& k) const {
    const auto [set, number] = parts(k);
    const DatasetClip& entry = set.clips[std::stoul(number)];
    auto out = std::make_shared<Recording>();
    out->clip = load_clip(set, entry);
    if (!out->clip.rotations.defined()) throw Error(set.folder + "/" + entry.file, "has no rotations");
    const Room room = rooms.get(k.substr(0, k.find('/') + 1) + entry.scene);
    out->offsets = basis_point_offsets(*room.query, anchor_positions(out->clip)).to(torch::kHalf);
    out->body_shape = body_shape_features(builtin_body(), body_betas(out->clip));
    for (int64_t start = 0; start + frames <= out->clip.frames(); start += stride) {
      const Clip window = slice(out->clip, start, start + frames);
      const double yaw = -canonical_transform(window).yaw;
      out->grids.push_back(packed(scene_occupancy(*room.query, window.joints[0][0], yaw)));
      out->floors.push_back(packed(scene_floor(*room.query, window.joints[0][0], yaw)));
    }
    return out;
  }
};

Data::Data(const std::vector<std::string>& folders, const std::string& split, const Config& config, int64_t stride)
    : impl_(std::make_unique<Impl>()) {
  impl_->frames = config.frames;
  impl_->stride = stride;
  for (const std::string& folder : folders) {
    impl_->sets.push_back(open_dataset(folder));
    const Dataset& set = impl_->sets.back();
    if (set.parents != standard_parents()) throw Error(folder, "is not on the standard skeleton");
    if (set.rate != config.rate)
      throw Error(folder,
                  "has " + std::to_string(set.rate) + " frames a second, the model " + std::to_string(config.rate));
    for (size_t c = 0; c < set.clips.size(); ++c) {
      if (set.clips[c].scene.empty() || (split != "all" && set.clips[c].split != split)) continue;
      require_files(set, set.clips[c]);
      for (int64_t start = 0; start + config.frames <= set.clips[c].frames; start += stride)
        impl_->places.push_back(
            {static_cast<int32_t>(impl_->sets.size() - 1), static_cast<int32_t>(c), static_cast<int32_t>(start)});
    }
  }
}

Data::~Data() = default;

int64_t Data::size() const { return static_cast<int64_t>(impl_->places.size()); }

Sample Data::sample(int64_t index) const {
  const torch::NoGradGuard no_gradients;
  const Place& place = impl_->places.at(static_cast<size_t>(index));
  const auto recording = impl_->recordings.get(Impl::key(place.set, std::to_string(place.clip)));
  const Clip window = slice(recording->clip, place.start, place.start + impl_->frames);
  const GroundTransform to_canonical = canonical_transform(window);
  const Clip canonical = transformed(window, to_canonical);
  Sample out;
  out.features = clip_features(canonical);
  const auto number = static_cast<size_t>(place.start / impl_->stride);
  out.occupancy = unpacked(recording->grids.at(number), {24, 48, 48});
  out.floor = unpacked(recording->floors.at(number), {96, 96});
  out.offsets = recording->offsets.slice(0, place.start, place.start + impl_->frames)
                    .to(torch::kFloat32)
                    .matmul(yaw_matrix(to_canonical.yaw).t());
  out.body_shape = recording->body_shape;
  out.bones = window.skeleton.offsets;
  return out;
}

Tensor Data::features(int64_t index) const {
  const torch::NoGradGuard no_gradients;
  const Place& place = impl_->places.at(static_cast<size_t>(index));
  const Clip window = slice(load_clip(impl_->sets[place.set], impl_->sets[place.set].clips[place.clip]), place.start,
                            place.start + impl_->frames);
  return clip_features(transformed(window, canonical_transform(window)));
}

Data::Window Data::window(int64_t index) const {
  const Place& place = impl_->places.at(static_cast<size_t>(index));
  const auto recording = impl_->recordings.get(Impl::key(place.set, std::to_string(place.clip)));
  return {slice(recording->clip, place.start, place.start + impl_->frames), impl_->room(place).scene,
          impl_->sets[place.set].clips[place.clip].file + " " + std::to_string(place.start)};
}

}  // namespace inhabit::inbetween
