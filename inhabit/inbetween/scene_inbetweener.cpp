#include "inhabit/inbetween/scene_inbetweener.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <utility>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/fill_window.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/sample.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/feet.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/motion/transfer.h"
#include "inhabit/nn/instance_pool.h"
#include "inhabit/scene/floor.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr int64_t kOverlap = 60;      // frames of a window that the one before filled (supplement 8.2)
constexpr int64_t kLeastOverlap = 8;  // fewer do not tell how fast everything moves
constexpr double kFootNoise = 0.05;   // metres that a foot of a noisy key may be moved by, at least
constexpr float kWithinReach = 2.5F;  // metres from the keys that obstacles are looked for
constexpr int64_t kRedone = 8;        // of a noise-aware model: a window's last key stays as noisy as it was

/// Key poses on the standard skeleton and where they stand at a model's rate.
struct KeyedClip {
  Clip clip;                  // the frames `keys` of it are the poses; those between repeat the pose before
  std::vector<int64_t> keys;  // in order, the first 0, the last its last frame
  SourcePoses source;         // the same poses on the skeleton that they came on
};

std::vector<int64_t> asked_keys(const Clip& clip, const Options& options) {
  if (clip.frames() < 2) throw Error(options.name, "has fewer than two frames");
  if (options.keys.empty()) return {0, clip.frames() - 1};
  const auto& keys = options.keys;
  if (keys.size() < 2) throw Error("key frames", "fewer than two");
  if (keys.front() != 0 || keys.back() != clip.frames() - 1)
    throw Error("key frames", "the first and the last frame must be among them");
  for (size_t i = 1; i < keys.size(); ++i)
    if (keys[i] <= keys[i - 1]) throw Error("key frames", "are not in order");
  return keys;
}

/// The poses at `asked` frames of a clip at the nearest frames of `rate`; of several in one the first, but the clip's
/// last stands.
KeyedClip keyed_clip(const Clip& source, const std::vector<int64_t>& asked, double rate, const std::string& name) {
  const bool standard =
      source.skeleton.parents == standard_parents() && source.rotations.defined() && source.trans.defined();
  Clip poses_there = standard ? source : retarget(source, name);
  poses_there.file = {};
  if (poses_there.translations.defined()) {  // the model knows rigid bones
    poses_there.translations = torch::Tensor();
    poses_there.joints = joint_positions(poses_there.skeleton, poses_there.rotations, poses_there.trans);
  }
  KeyedClip out;
  std::vector<int64_t> frames;
  for (const int64_t frame : asked) {
    const int64_t key = std::llround(static_cast<double>(frame) * rate / source.rate);
    if (!out.keys.empty() && key == out.keys.back()) {
      if (frame + 1 < source.frames() || out.keys.size() == 1) continue;
      out.keys.pop_back();
      frames.pop_back();
    }
    out.keys.push_back(key);
    frames.push_back(frame);
  }
  if (out.keys.size() < 2)
    throw Error(name, fmt::format("is shorter than two frames of the model's, 1/{:g} s each", rate));
  std::vector<int64_t> held;
  for (size_t k = 0; k + 1 < out.keys.size(); ++k)
    held.insert(held.end(), static_cast<size_t>(out.keys[k + 1] - out.keys[k]), frames[k]);
  held.push_back(frames.back());
  out.clip = frames_at(poses_there, held);
  out.clip.rate = rate;
  out.source = poses_of(source, poses_there, asked, frames, out.keys);
  for (const Tensor& t : {out.clip.joints, out.clip.rotations, out.clip.trans})
    if (!t.index_select(0, torch::tensor(out.keys)).isfinite().all().item<bool>())
      throw Error(name, "a key pose is not finite");
  return out;
}

/// Footskate cleanup of a filled clip; the feet of clean keys stay.
Clip with_clean_feet(const Clip& motion, const Clip& key_poses, const std::vector<int64_t>& keys, const Tensor& given,
                     bool noisy, double floor) {
  const Tensor feet = torch::tensor({7, 8, 10, 11}) + kJointGroups;
  const bool clean_keys = !noisy && (!given.defined() || given.index_select(0, feet).any().item<bool>());
  const std::vector<int64_t> fixed = clean_keys ? keys : std::vector<int64_t>{0, motion.frames() - 1};
  if (!noisy || given.defined()) return clean_feet(motion, fixed, floor);
  const Tensor missed = frames_at(motion, keys).joints - key_poses.joints;
  return clean_feet(motion, fixed, floor, keys, std::max(kFootNoise, 3 * missed.norm(2, {2}).mean().item<double>()));
}

/// What lies within reach of a way from key to key, over the floor.
Eigen::AlignedBox3f around_keys(const Clip& keys, double floor) {
  Eigen::AlignedBox3f box;
  const Tensor places = keys.joints.reshape({-1, 3}) - torch::tensor({0., floor, 0.});
  for (const Tensor& corner : {std::get<0>(places.min(0)), std::get<0>(places.max(0))})
    box.extend(Eigen::Vector3f(corner[0].item<float>(), corner[1].item<float>(), corner[2].item<float>()));
  box.min() -= Eigen::Vector3f::Constant(kWithinReach);
  box.max() += Eigen::Vector3f::Constant(kWithinReach);
  return box;
}

}  // namespace

struct SceneInbetweener::Impl {
  Networks networks;
  DiffusionSchedule schedule;
  mutable nn::InstancePool<FastDenoiser> denoisers;
};

SceneInbetweener::SceneInbetweener(const Networks& networks)
    : impl_(new Impl{networks, cosine_schedule(networks.config.diffusion_steps),
                     nn::InstancePool<FastDenoiser>([network = networks.network] { return FastDenoiser(network); })}) {
  const int64_t anchors = builtin_body().anchors.size(0);
  if (config().local_scene && config().anchors != anchors)
    throw Error("in-betweening", "the model looks from " + std::to_string(config().anchors) +
                                     " anchors, the body has " + std::to_string(anchors));
  impl_->networks.network->eval();
}
SceneInbetweener::~SceneInbetweener() = default;
SceneInbetweener::SceneInbetweener(SceneInbetweener&&) noexcept = default;

SceneInbetweener SceneInbetweener::load(const std::string& path) { return SceneInbetweener(load_networks(path)); }

const Config& SceneInbetweener::config() const { return impl_->networks.config; }

bool SceneInbetweener::has_baseline() const { return config().from_interpolation || config().residual; }

Result SceneInbetweener::run(const Clip& clip, const Scene& scene, const Options& options) const {
  const torch::NoGradGuard no_gradients;
  const Config& c = config();
  if (options.stage == Stage::baseline && !has_baseline())
    throw Error("stage", "this model starts from no interpolation");
  if (options.key_groups.defined() && !c.partial_keys) throw Error("joints", "this model takes whole key poses only");
  const int64_t steps = options.steps > 0 ? options.steps : c.inference.steps;
  if (steps > c.diffusion_steps) throw Error("steps", "are more than the model's " + std::to_string(c.diffusion_steps));
  KeyedClip keyed = keyed_clip(clip, asked_keys(clip, options), c.rate, options.name);
  const auto windows = fill_windows(keyed.keys, c.frames, kOverlap, kLeastOverlap, c.t_star > 0 ? kRedone : 0);

  Result out;
  out.keys = keyed.keys;
  out.key_poses = frames_at(keyed.clip, keyed.keys);
  out.floor_assumed = scene.empty();
  out.scene = out.floor_assumed ? assumed_floor(out.key_poses) : scene;
  const SceneQuery query(out.scene);
  auto denoiser = impl_->denoisers.take();
  const double floor = floor_under(out.key_poses, query);
  const SceneDistances distances =
      c.residual ? SceneDistances(out.scene, floor, around_keys(out.key_poses, floor)) : SceneDistances();
  Filling f{impl_->networks, impl_->schedule, *denoiser, query, options, keyed.keys, steps, {},
            floor,           distances,       keyed.clip};
  for (Tensor* part : {&f.motion.joints, &f.motion.rotations, &f.motion.trans}) *part = part->clone();
  f.motion.betas = body_betas(out.key_poses);
  f.body_shape = body_shape_features(builtin_body(), f.motion.betas).unsqueeze(0);
  for (size_t w = 0; w < windows.size(); ++w) fill_window(f, windows[w], w, windows.size());
  if (options.clean_feet && options.stage == Stage::finished)
    f.motion = with_clean_feet(f.motion, out.key_poses, keyed.keys, options.key_groups, c.t_star > 0, f.floor);
  f.motion.betas = clip.betas;
  out.motion = std::move(f.motion);
  if (!options.standard) {
    SourcePoses& source = keyed.source;
    // Noisy keys are cleaned and partial ones leave joints open, but for the ends.
    source.exact.assign(source.frames.size(), c.t_star == 0 && !options.key_groups.defined());
    source.exact.front() = source.exact.back() = true;
    out.on_source = on_source_skeleton(out.motion, source, source.frames.back() + 1);
  }
  if (options.stage != Stage::finished) return out;
  const CollisionMeter meter(builtin_body(), out.scene);
  out.key_collides = meter.measure(out.key_poses).depth > 0;
  if (options.collisions) out.collides = meter.measure(out.motion).depth > 0;
  return out;
}

}  // namespace inhabit::inbetween
