#include "inhabit/inbetween/sample.h"

#include <algorithm>
#include <map>
#include <mutex>

#include "inhabit/body/body_model.h"
#include "inhabit/body/fit.h"
#include "inhabit/data/cache.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/math/furthest_points.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/placed_body.h"
#include "inhabit/scene/basis_points.h"
#include "inhabit/scene/occupancy.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr size_t kScenesKept = 256, kClipsKept = 4096;

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
  Tensor offsets;                     // (T, A, 3) half, world axes
  Tensor body_shape;                  // (7)
  std::vector<Tensor> grids, floors;  // packed, of each window
};

/// Vertices of the built-in body by furthest point sampling; found once for each number.
Tensor spread_anchors(int64_t count) {
  static std::mutex mutex;
  static std::map<int64_t, Tensor> known;
  const std::lock_guard<std::mutex> lock(mutex);
  Tensor& anchors = known[count];
  if (!anchors.defined()) anchors = furthest_point_indices(builtin_body().template_vertices, count);
  return anchors;
}

struct Room {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const SceneQuery> query;
};

}  // namespace

Tensor body_betas(const Clip& clip) {
  return clip.betas.defined() ? clip.betas : fit_shape(builtin_body(), clip.joints);
}

Tensor anchor_positions(const Clip& clip, int64_t count) {
  Clip shaped = clip;
  shaped.betas = body_betas(clip);
  BodyModel body = builtin_body();  // tensors are shared
  body.anchors = spread_anchors(count);
  return anchor_points(shaped, body);
}

Tensor scene_occupancy(const SceneQuery& scene, const Tensor& root, double yaw, int side) {
  const Eigen::Vector3d center(root[0].item<double>(), root[1].item<double>(), root[2].item<double>());
  return occupancy_grid(scene.solid(), center, yaw, {{side, side / 2, side}}).permute({1, 0, 2}).contiguous();
}

struct Data::Impl {
  int anchors, side;  // of the configuration
  WindowSet windows;
  mutable RecentCache<std::shared_ptr<const Recording>> recordings{kClipsKept,
                                                                   [this](const std::string& k) { return record(k); }};
  mutable RecentCache<std::shared_ptr<const Scene>> scenes{
      kScenesKept, [this](const std::string& k) { return std::make_shared<Scene>(windows.load_scene(k)); }};
  mutable RecentCache<Room> rooms{kScenesKept, [this](const std::string& k) { return read_room(k); }};

  Room read_room(const std::string& key) const {
    auto scene = scenes.get(key);
    return {scene, std::make_shared<SceneQuery>(*scene)};
  }
  std::shared_ptr<const Recording> record(const std::string& key) const {
    auto out = std::make_shared<Recording>();
    out->clip = windows.load_clip(key);
    if (!out->clip.rotations.defined()) throw Error(windows.file(key), "has no rotations");
    const Room room = rooms.get(windows.scene_key_of_clip(key));
    out->offsets = basis_point_offsets(*room.query, anchor_positions(out->clip, anchors)).to(torch::kHalf);
    out->body_shape = body_shape_features(builtin_body(), body_betas(out->clip));
    for (int64_t start = 0; start + windows.frames() <= out->clip.frames(); start += windows.stride()) {
      const Clip window = slice(out->clip, start, start + windows.frames());
      const double yaw = -canonical_transform(window).yaw;
      out->grids.push_back(packed(scene_occupancy(*room.query, window.joints[0][0], yaw, side)));
      out->floors.push_back(packed(scene_floor(*room.query, window.joints[0][0], yaw)));
    }
    return out;
  }
  Clip window(const Clip& clip, int64_t index) const {
    const int64_t start = windows.place(index).start;
    return slice(clip, start, start + windows.frames());
  }
};

Data::Data(const std::vector<std::string>& folders, const std::string& split, const Config& config, int64_t stride)
    : impl_(new Impl{config.anchors, config.scene_encoder.side,
                     WindowSet(folders, split, config.frames, stride, config.rate, [](const Dataset& set) {
                       if (set.parents != standard_parents())
                         throw Error(set.folder, "is not on the standard skeleton");
                     })}) {}

Data::~Data() = default;

const WindowSet& Data::windows() const { return impl_->windows; }

Sample Data::sample(int64_t index) const {
  const torch::NoGradGuard no_gradients;
  const WindowSet& windows = impl_->windows;
  const auto recording = impl_->recordings.get(windows.clip_key(index));
  const Clip window = impl_->window(recording->clip, index);
  const GroundTransform to_canonical = canonical_transform(window);
  Sample out;
  out.features = clip_features(transformed(window, to_canonical));
  const auto number = static_cast<size_t>(windows.number(index));
  const int64_t side = impl_->side;
  out.occupancy = unpacked(recording->grids.at(number), {side / 2, side, side});
  out.floor = unpacked(recording->floors.at(number), {96, 96});
  const int64_t start = windows.place(index).start;
  out.offsets = recording->offsets.slice(0, start, start + windows.frames())
                    .to(torch::kFloat32)
                    .matmul(yaw_matrix(to_canonical.yaw).t());
  out.body_shape = recording->body_shape;
  out.bones = window.skeleton.offsets;
  return out;
}

Tensor Data::features(int64_t index) const {
  const torch::NoGradGuard no_gradients;
  const Clip window = impl_->window(impl_->windows.load_clip(impl_->windows.clip_key(index)), index);
  return clip_features(transformed(window, canonical_transform(window)));
}

Window Data::window(int64_t index) const {
  const WindowSet& windows = impl_->windows;
  const std::string key = windows.clip_key(index);
  const Clip clip = windows.load_clip(key);
  if (!clip.rotations.defined()) throw Error(windows.file(key), "has no rotations");
  return {windows.entry(index).file + " " + std::to_string(windows.place(index).start),
          impl_->window(clip, index),
          {},
          impl_->scenes.get(windows.scene_key(index))};
}

}  // namespace inhabit::inbetween
