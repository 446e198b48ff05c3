#include "inhabit/inbetween/scene_inbetweener.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "inhabit/body/body_model.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/fill_window.h"
#include "inhabit/inbetween/keyed_clip.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/poses.h"
#include "inhabit/inbetween/sample.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/motion/pose_track.h"
#include "inhabit/motion/transfer.h"
#include "inhabit/nn/instance_pool.h"
#include "inhabit/refine/refine_clip.h"
#include "inhabit/scene/floor.h"
#include "inhabit/scene/objects.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr int64_t kOverlap = 60;        // frames of a window that the one before filled (supplement 8.2)
constexpr int64_t kLeastOverlap = 8;    // fewer do not tell how fast everything moves
constexpr double kMostNoiseAsked = 10;  // degrees and cm
constexpr double kLeastNoise = 0.5;     // of keys that are noisy by nobody knows how much
constexpr double kUntoldNoise = 1;      // of keys between which there is no motion that would tell
constexpr float kWithinReach = 2.5F;    // metres from the keys that obstacles are looked for
constexpr int64_t kRedone = 8;          // of a noise-aware model: a window's last key stays as noisy as it was
constexpr int64_t kMostSamples = 1000;

int64_t frame_of(double seconds, double rate, int64_t last) {
  return std::min<int64_t>(last, std::llround(seconds * rate));
}

/// The filled clip after refine/: exact keys stay, and what partial keys and contacts put somewhere.
Clip refined(const Filling& f, const KeyedClip& asked, const Result& result, const std::string& name) {
  const Tensor& groups = f.options.key_groups;
  const int64_t last = f.motion.frames() - 1;
  refine::Options options;
  options.generated = true;
  options.standard = true;
  options.name = name;
  if (!f.options.controls.loop) options.feet = f.feet;  // a loop is mixed from two courses of its motion
  const std::vector<int64_t> joints = key_joints_of(groups);
  for (size_t k = 0; k < asked.keys.size(); ++k) {
    const int64_t frame = asked.keys[k];
    if (frame == 0 || frame == last || !(f.noisy || groups.defined())) {
      options.keep_frames.push_back(frame);
      continue;
    }
    for (const refine::JointTarget& target :
         refine::joint_targets(result.key_poses, static_cast<int64_t>(k), frame, joints))
      options.given.push_back({target.joint, target.offset, target.place, frame, frame});
  }
  for (const JointContact& contact : asked.controls.contacts)
    options.given.push_back({contact.joint, contact.offset, contact.place, frame_of(contact.from, f.motion.rate, last),
                             frame_of(contact.to, f.motion.rate, last)});
  return refine::refine(f.motion, result.scene, options).clip;
}

/// What is constrained frame by frame.
FrameConstraints constraints_of(const KeyedClip& keyed, const Tensor& key_groups, double rate) {
  const int64_t frames = keyed.clip.frames();
  FrameConstraints out;
  out.groups = torch::zeros({frames, kKeyGroups});
  for (const int64_t key : keyed.keys) {
    if (key_groups.defined() && key > 0 && key + 1 < frames)
      out.groups[key].copy_(key_groups);
    else
      out.groups[key].fill_(1);
  }
  for (const JointContact& contact : keyed.controls.contacts) {
    const int64_t last = frame_of(contact.to, rate, frames - 1);
    for (int64_t frame = frame_of(contact.from, rate, frames - 1); frame <= last; ++frame) {
      refine::JointTarget target;
      target.frame = frame;
      target.joint = contact.joint;
      target.place = contact.place;
      target.offset = contact.offset;
      out.contacts.push_back(target);
    }
  }
  if (!keyed.controls.root_path.empty())
    out.path = path_curve(keyed.controls.root_path, keyed.clip.root_path(), keyed.keys, rate);
  return out;
}

/// What lies within reach of a path from key to key, over the floor.
Eigen::AlignedBox3f around_keys(const Clip& keys, double floor) {
  Eigen::AlignedBox3f box;
  const Tensor places = keys.joints.reshape({-1, 3}) - torch::tensor({0., floor, 0.});
  for (const Tensor& corner : {std::get<0>(places.min(0)), std::get<0>(places.max(0))})
    box.extend(Eigen::Vector3f(corner[0].item<float>(), corner[1].item<float>(), corner[2].item<float>()));
  box.min() -= Eigen::Vector3f::Constant(kWithinReach);
  box.max() += Eigen::Vector3f::Constant(kWithinReach);
  return box;
}

/// Throws Error where a model of this configuration cannot do what is asked for.
void require_possible(const Config& c, const Options& options) {
  if (options.key_groups.defined() && !c.partial_keys) throw Error("joints", "this model takes whole key poses only");
  if (!c.residual && !(options.controls.contacts.empty() && options.controls.root_path.empty()))
    throw Error("controls", "this model takes neither contacts nor a root path");
  if (options.temperature && !(*options.temperature >= 0 && *options.temperature <= 2))
    throw Error("temperature", "is not from 0 to 2");
  const double noise = options.noise.value_or(0);
  if (!(noise >= 0 && noise <= kMostNoiseAsked))
    throw Error("noise level", "is not from 0 to " + std::to_string(static_cast<int>(kMostNoiseAsked)));
  if (noise > 0 && !c.takes_noise())
    throw Error("noise level", c.t_star > 0 ? "this model cleans noisy key frames without being told"
                                            : "this model was not trained on noisy key frames");
  if (options.steps > c.diffusion_steps)
    throw Error("steps", "are more than the model's " + std::to_string(c.diffusion_steps));
}

/// Whether a clip has nothing but key poses: each stays until the next (poses_at_times).
bool poses_alone(const Clip& clip, const std::vector<int64_t>& keys) {
  if (static_cast<int64_t>(keys.size()) == clip.frames()) return false;
  for (size_t k = 0; k + 1 < keys.size(); ++k) {
    const Tensor until_next = clip.joints.slice(0, keys[k], keys[k + 1]);
    if (!(until_next == until_next.slice(0, 0, 1)).all().item<bool>()) return false;
  }
  return true;
}

/// Level of noise on the clip's keys.
double noise_level(const Config& c, const Clip& clip, const std::vector<int64_t>& keys, const Options& options) {
  if (options.noise || !c.inference.noisy_keys) return options.noise.value_or(0);
  if (poses_alone(clip, keys)) return kUntoldNoise;
  if (!clip.joints.isfinite().all().item<bool>()) return kLeastNoise;  // frames that are no keys may be anything
  return std::clamp(measured_noise(clip), kLeastNoise, kMostNoiseAsked);
}

/// The keys of each pass: those of less than the whole weight are poses between what is there without them and what
/// they are, so that the first pass goes without them.
std::vector<std::vector<int64_t>> passes_of(const KeyedClip& keyed) {
  const std::vector<double>& weights = keyed.controls.key_weights;
  if (std::all_of(weights.begin(), weights.end(), [](double weight) { return weight >= 1; })) return {keyed.keys};
  std::vector<int64_t> whole;
  for (size_t k = 0; k < keyed.keys.size(); ++k)
    if (weights[k] == 1) whole.push_back(keyed.keys[k]);
  return {whole, keyed.keys};
}

/// Keys of less than the whole weight become poses between those of `motion`, found without them, and what they are.
void blend_into_keys(KeyedClip& keyed, const Clip& motion) {
  const std::vector<double>& weights = keyed.controls.key_weights;
  for (size_t k = 0; k < keyed.keys.size(); ++k) {
    if (weights[k] == 1) continue;
    const int64_t key = keyed.keys[k];
    const Clip there = mixed(frames_at(motion, {key}), frames_at(keyed.clip, {key}), {weights[k]});
    for (Tensor Clip::*part : {&Clip::joints, &Clip::rotations, &Clip::trans})
      (keyed.clip.*part)[key].copy_((there.*part)[0]);
  }
}

/// The file's poses, and which of them the motion meets exactly: noisy keys are cleaned and partial ones leave joints
/// open, but for the ends.
SourcePoses with_exact_keys(SourcePoses source, const Options& options, bool noisy) {
  source.exact.assign(source.frames.size(), !noisy && !options.key_groups.defined());
  source.exact.front() = source.exact.back() = true;
  for (size_t k = 0; k < source.exact.size(); ++k)
    if (!options.controls.key_weights.empty() && options.controls.key_weights[k] < 1) source.exact[k] = false;
  return source;
}

/// Which keys, and where `everywhere` which frames, are inside the scene, and how deep in what.
void mark_collisions(bool everywhere, Result& out) {
  const CollisionMeter meter(builtin_body(), out.scene);
  out.key_collides = meter.colliding_frames(out.key_poses);
  std::vector<int64_t> colliding;
  for (int64_t k = 0; k < out.key_collides.numel(); ++k)
    if (out.key_collides[k].item<bool>()) colliding.push_back(k);
  out.key_immersions = immersions_of(meter, out.key_poses, colliding);
  for (Immersion& immersion : out.key_immersions) immersion.frame = out.keys[static_cast<size_t>(immersion.frame)];
  if (!everywhere) return;
  out.collides = meter.colliding_frames(out.motion);
  out.immersions = immersions_of_stretches(meter, out.motion, out.collides);
}

}  // namespace

struct SceneInbetweener::Impl {
  Networks networks;
  DiffusionSchedule schedule;
  mutable nn::InstancePool<FastDenoiser> denoisers;
};

const std::map<std::string, Detours>& detours_by_name() {
  static const std::map<std::string, Detours> all = {
      {"learned", Detours::learned}, {"searched", Detours::searched}, {"straight", Detours::straight}};
  return all;
}

Detours detours_named(const std::string& name) {
  const auto found = detours_by_name().find(name);
  if (found == detours_by_name().end())
    throw Error("detours '" + name + "'", "is none of learned, searched and straight");
  return found->second;
}

SceneInbetweener::SceneInbetweener(const Networks& networks)
    : impl_(new Impl{networks, cosine_schedule(networks.config.diffusion_steps),
                     nn::InstancePool<FastDenoiser>([network = networks.network] { return FastDenoiser(network); })}) {
  impl_->networks.network->eval();
  if (impl_->networks.path) impl_->networks.path->eval();
  if (impl_->networks.feet) impl_->networks.feet->eval();
}
SceneInbetweener::~SceneInbetweener() = default;
SceneInbetweener::SceneInbetweener(SceneInbetweener&&) noexcept = default;

SceneInbetweener SceneInbetweener::load(const std::string& path) { return SceneInbetweener(load_networks(path)); }

const Config& SceneInbetweener::config() const { return impl_->networks.config; }

bool SceneInbetweener::has_baseline() const { return config().from_interpolation || config().residual; }

bool SceneInbetweener::has_path_net() const { return !impl_->networks.path.is_empty(); }

std::vector<Result> SceneInbetweener::run_samples(const Clip& clip, const Scene& scene, const Options& options,
                                                  int64_t samples) const {
  if (samples < 1 || samples > kMostSamples) throw Error("samples", "is not from 1 to " + std::to_string(kMostSamples));
  Options one = options;
  if (samples > 1) one.temperature = options.temperature.value_or(1);
  std::vector<Result> out;
  for (int64_t i = 0; i < samples; ++i) {
    one.seed = options.seed + static_cast<uint64_t>(i);
    one.progress = part_of(options.progress, i, samples);
    out.push_back(run(clip, scene, one));
  }
  return out;
}

Result SceneInbetweener::run(const Clip& clip, const Scene& scene, const Options& options) const {
  const torch::NoGradGuard no_gradients;
  const Config& c = config();
  if (options.stage == Stage::baseline && !has_baseline())
    throw Error("stage", "this model starts from no interpolation");
  require_possible(c, options);
  const int64_t steps = options.steps > 0 ? options.steps : c.inference.steps;
  const KeyedClip asked = keyed_clip(clip, options, c.rate);
  const double noise = noise_level(c, clip, asked.source.frames, options);
  const bool noisy = c.t_star > 0 || noise > 0;
  KeyedClip keyed = options.controls.loop ? twice(asked) : asked;

  Result out;
  out.keys = asked.keys;
  out.noise = noise;
  out.key_poses = frames_at(asked.clip, asked.keys);
  out.floor_assumed = scene.empty();
  out.scene =
      out.floor_assumed ? assumed_floor(out.key_poses) : rooms_looking_in(scene, out.key_poses.joints.select(1, 0));
  const SceneQuery query(out.scene);
  auto denoiser = impl_->denoisers.take();
  const Clip all_poses = frames_at(keyed.clip, keyed.keys);
  const double floor = floor_under(out.key_poses, query);
  const SceneDistances distances =
      c.residual ? SceneDistances(out.scene, floor, around_keys(all_poses, floor)) : SceneDistances();

  const std::vector<std::vector<int64_t>> passes = passes_of(keyed);
  std::vector<std::vector<FillWindow>> windows;
  int64_t done_before = 0, all = 0;
  for (const std::vector<int64_t>& keys : passes) {
    windows.push_back(fill_windows(keys, c.frames, kOverlap, kLeastOverlap, noisy ? kRedone : 0, clip.rate / c.rate,
                                   options.keys_name));
    all += static_cast<int64_t>(windows.back().size()) * steps;
  }
  Options asking = options;
  if (options.progress) asking.progress = [&](int64_t done, int64_t) { options.progress(done_before + done, all); };
  const Tensor body_shape = body_shape_features(builtin_body(), body_betas(out.key_poses)).unsqueeze(0);
  std::optional<Filling> filling;
  for (size_t pass = 0; pass < passes.size(); ++pass) {
    if (pass > 0) {
      blend_into_keys(keyed, filling->motion);
      out.key_poses = frames_at(keyed.clip, out.keys);
    }
    KeyedClip now = keyed;
    now.keys = passes[pass];
    filling.emplace(Filling{impl_->networks,
                            impl_->schedule,
                            *denoiser,
                            query,
                            asking,
                            passes[pass],
                            noisy,
                            noise,
                            steps,
                            options.temperature.value_or(0),
                            body_shape,
                            floor,
                            distances,
                            constraints_of(now, options.key_groups, c.rate),
                            keyed.clip,
                            {}});
    Filling& f = *filling;
    for (Tensor* part : {&f.motion.joints, &f.motion.rotations, &f.motion.trans}) *part = part->clone();
    f.motion.betas = body_betas(out.key_poses);
    for (size_t w = 0; w < windows[pass].size(); ++w) fill_window(f, windows[pass], w);
    done_before += static_cast<int64_t>(windows[pass].size()) * steps;
  }
  Filling& f = *filling;
  if (options.controls.loop) f.motion = folded(f.motion);
  if (options.refine && options.stage == Stage::finished) f.motion = refined(f, asked, out, options.name);
  for (const int64_t key : f.unreached)
    if (std::binary_search(out.keys.begin(), out.keys.end(), key)) out.unreached.push_back(key);
  f.motion.betas = clip.betas;
  out.motion = std::move(f.motion);
  out.contact_gaps = contact_gaps(options.controls.contacts, out.motion);
  if (!options.standard)
    out.on_source =
        on_source_skeleton(out.motion, with_exact_keys(asked.source, options, noisy), asked.source.frames.back() + 1);
  if (options.stage == Stage::finished) mark_collisions(options.collisions, out);
  return out;
}

}  // namespace inhabit::inbetween
