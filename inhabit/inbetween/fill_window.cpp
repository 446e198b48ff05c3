#include "inhabit/inbetween/fill_window.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "inhabit/inbetween/conditioning.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/learned_detours.h"
#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/inbetween/residual.h"
#include "inhabit/inbetween/residual_sample.h"
#include "inhabit/inbetween/sample.h"
#include "inhabit/math/random.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/refine/refine_generated.h"
#include "inhabit/scene/basis_points.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr int64_t kDenseKeys = 6;      // frames from one key to the next, in the mean
constexpr int kWristFromShoulder = 4;  // joints
constexpr double kUnbound = std::numeric_limits<double>::infinity();
// Metres, standard deviations. The root may be beside its path, since people sway, but keeps the height that the
// network gives it, where a joint is in contact too: nobody is lifted by a hand.
constexpr double kContact = 0.0005, kHeight = 0.002;
const Eigen::Vector3d kPathWidth(0.02, 0.01, 0.02);

/// What each frame of a window constrains (c.frames, 25).
Tensor groups_of(const Filling& f, const FillWindow& window) {
  Tensor groups = torch::zeros({f.config().frames, kKeyGroups});
  groups.slice(0, 0, window.last + 1 - window.first)
      .copy_(f.constraints.groups.slice(0, window.first, window.last + 1));
  groups.slice(0, 0, window.known + 1 - window.first).fill_(1);
  return groups;
}

/// The conditioning of a window: frames that are known already, then key frames.
struct WindowConditioning {
  Conditioning conditioning;
  GroundTransform to_canonical;
  std::vector<int64_t> unreached;  // frames of the window
};

WindowConditioning condition(const Filling& f, const FillWindow& window) {
  const Config& c = f.config();
  std::vector<int64_t> at;
  const Tensor groups = groups_of(f, window);
  Tensor always = torch::zeros({c.frames});
  for (int64_t frame = window.first; frame <= window.known; ++frame) {
    at.push_back(frame);
    always[frame - window.first].fill_(1);
  }
  for (const int64_t key : f.keys) {
    if (key <= window.known || key > window.last) continue;
    at.push_back(key);
    if (key == window.last) always[key - window.first].fill_(1);
  }
  const Tensor places = torch::tensor(at) - window.first;
  const Clip poses = frames_at(f.motion, at);
  WindowConditioning out;
  out.to_canonical = canonical_transform(poses);
  out.to_canonical.shift.y() -= f.floor;
  const double yaw = out.to_canonical.yaw;
  const Tensor metres = clip_features(transformed(poses, out.to_canonical)), root = poses.joints[0][0];
  Conditioning& on = out.conditioning;
  on.groups = groups.unsqueeze(0);
  on.constraints.values = torch::zeros({1, kFeatureCount, c.frames})
                              .index_copy_(2, places, f.networks.scale.to_network(metres).t().unsqueeze(0));
  on.constraints.mask = feature_mask(groups).t().unsqueeze(0);
  on.constraints.always = on.constraints.mask * always;
  on.constraints.t_star = c.t_star;
  on.constraints.imposed = false;
  on.shape = f.body_shape;
  if (c.global_scene) on.occupancy = scene_occupancy(f.query, root, -yaw, c.scene_encoder.side).unsqueeze(0);
  Tensor offsets = torch::zeros({c.frames, c.anchors, 3});
  if (c.local_scene)
    offsets.index_copy_(0, places,
                        basis_point_offsets(f.query, anchor_positions(poses, c.anchors)).matmul(yaw_matrix(yaw).t()));
  on.offsets = offsets.permute({1, 2, 0}).unsqueeze(0);
  on.detours = torch::zeros({1, c.frames, 2});
  if (f.options.detours != Detours::straight && c.from_interpolation && c.around_obstacles && c.global_scene) {
    const Tensor trajectory = torch::zeros({c.frames, 3}).index_copy_(0, places, metres.slice(1, 0, 3));
    on.detours =
        detours_around(scene_floor(f.query, root, -yaw, f.floor), trajectory, groups, &out.unreached).unsqueeze(0);
  }
  return out;
}

/// A key frame that comes out as it went in.
bool exact_key(const Filling& f, int64_t frame) {
  const bool clean = !f.noisy && !f.options.key_groups.defined();
  return (clean || frame == 0 || frame == f.last_frame()) && std::binary_search(f.keys.begin(), f.keys.end(), frame);
}

/// What refinement brings the prediction of a window to: known frames and clean whole keys exactly.
refine::KeyPoses key_poses(const Filling& f, const FillWindow& window, const Clip& predicted) {
  refine::KeyPoses out;
  std::vector<int64_t> at;
  const auto add = [&](int64_t frame, bool exact) {
    at.push_back(frame);
    out.frames.push_back(frame - window.first);
    out.exact.push_back(exact ? 1 : 0);
  };
  for (int64_t frame = window.first; frame <= window.known; ++frame) add(frame, true);
  const std::vector<int64_t> joints = key_joints_of(f.options.key_groups);
  for (const int64_t key : f.keys) {
    if (key <= window.known || key > window.last) continue;
    const bool exact = exact_key(f, key);
    if (exact || joints.empty()) {
      add(key, exact);
      continue;
    }
    for (const refine::JointTarget& target : refine::joint_targets(f.motion, key, key - window.first, joints))
      out.targets.push_back(target);
  }
  out.poses = frames_at(f.motion, at);
  const auto height = [&](int64_t frame) { return predicted.joints[frame][0][1].item<double>(); };
  for (refine::JointTarget target : f.constraints.contacts) {
    if (target.frame <= window.known || target.frame > window.last) continue;
    target.frame -= window.first;
    target.sigma.setConstant(kContact);
    out.targets.push_back(target);
    out.targets.push_back({target.frame, 0, {0, height(target.frame), 0}, {kUnbound, kHeight, kUnbound}});
  }
  if (f.constraints.path.defined()) {
    const auto path = f.constraints.path.accessor<float, 2>();
    for (int64_t frame = window.known + 1; frame <= window.last; ++frame)
      if (path[frame][2] > 0)
        out.targets.push_back(
            {frame - window.first, 0, {path[frame][0], height(frame - window.first), path[frame][1]}, kPathWidth});
  }
  return out;
}

/// What a network of features says of a window.
Clip predict_features(Filling& f, const FillWindow& window, const std::function<void(int64_t)>& progress,
                      uint64_t seed) {
  const Config& c = f.config();
  const WindowConditioning on = condition(f, window);
  for (const int64_t frame : on.unreached) f.unreached.push_back(window.first + frame);
  KeyConstraints constraints = on.conditioning.constraints;
  const DenoiserInput in = denoiser_input(f.networks, on.conditioning);
  const auto predict = [&](const Tensor& x, int64_t t) {
    if (c.global_scene)
      return in.baseline + f.denoiser.guided(x, in.mask, in.local, t, in.scene, in.shape, c.inference.guidance);
    return in.baseline + f.denoiser.forward(x, in.mask, in.local, torch::full({1}, t, torch::kInt64), in.shape);
  };
  Denoise denoise = predict;
  if (!c.keys_seen) {  // inpainting: keys are put into what is predicted, and get the noise of x_t with it
    const Tensor keyed = constraints.mask > 0;
    constraints.mask = torch::zeros_like(constraints.mask);
    constraints.always = constraints.mask;
    denoise = [=, values = constraints.values](const Tensor& x, int64_t t) {
      return torch::where(keyed, values, predict(x, t));
    };
  }
  const auto noise = seeded_noise(1, kFeatureCount, c.frames, seed);
  const Tensor sampled = f.options.stage == Stage::baseline
                             ? in.baseline
                             : sample(f.schedule, f.options.sampler, f.steps, denoise, constraints, noise, progress);
  const Tensor features = f.networks.scale.from_network(sampled[0].t());
  return transformed(clip_of_features(features, f.motion), on.to_canonical.inverse());
}

/// How noisy a window's keys are: the ends of the clip and what is filled already have no noise.
KeyNoise noise_of(const Filling& f, const FillWindow& window) {
  KeyNoise out{f.noise, std::vector<char>(static_cast<size_t>(f.config().frames), 0), f.config().rate};
  for (int64_t frame = window.first; frame <= window.known; ++frame)
    out.exact[static_cast<size_t>(frame - window.first)] = 1;
  if (window.last == f.last_frame()) out.exact[static_cast<size_t>(window.last - window.first)] = 1;
  return out;
}

/// Detours from key to key as PathNet says. Where it knows none, and of a model without it, as A* says.
Tensor detours_of_window(const Filling& f, const Poses& keys, const Tensor& groups, uint64_t seed,
                         std::vector<int64_t>& unreached) {
  if (f.options.detours == Detours::searched || !f.networks.path)
    return detours_of_poses(keys, groups, f.distances, &unreached);
  std::vector<int64_t> unknown;
  Tensor moves = learned_detours(f.networks.path, keys, groups, f.distances, f.temperature, seed, &unknown);
  if (unknown.empty()) return moves;
  const Tensor searched = detours_of_poses(keys, groups, f.distances, &unreached);
  std::erase_if(unreached, [&](int64_t key) { return !std::binary_search(unknown.begin(), unknown.end(), key); });
  for (const RootLeg& leg : root_legs(root_places(keys), groups))
    if (std::binary_search(unknown.begin(), unknown.end(), leg.to))
      moves.slice(0, leg.from + 1, leg.to).copy_(searched.slice(0, leg.from + 1, leg.to));
  return moves;
}

/// The interpolated keys of a window, the root along the path of the controls, else around obstacles.
Baseline baseline_of_window(Filling& f, const FillWindow& window, const Clip& keys, uint64_t seed) {
  Tensor groups = groups_of(f, window);
  std::vector<int64_t> unreached;
  Tensor moves = torch::zeros({f.config().frames, 2});
  Poses poses = poses_of(keys, f.floor);
  const KeyNoise noise = noise_of(f, window);
  if (f.options.detours != Detours::straight) moves = detours_of_window(f, poses, groups, seed, unreached);
  for (const int64_t frame : unreached) f.unreached.push_back(window.first + frame);
  for (const refine::JointTarget& contact : f.constraints.contacts) {
    if (contact.frame <= window.known || contact.frame > window.last) continue;
    const int64_t frame = contact.frame - window.first;
    Eigen::Vector3f place = (contact.place - Eigen::Vector3d(0, f.floor, 0)).cast<float>();
    if (!contact.offset
             .isZero()) {  // a palm: the wrist is as far before it as seen from the shoulder of the key before
      const Eigen::Vector3f& shoulder = poses.joints[Poses::at(frame, contact.joint - kWristFromShoulder)];
      place -= static_cast<float>(contact.offset.norm()) * (place - shoulder).normalized();
    }
    poses.joints[Poses::at(frame, contact.joint)] = place;
    groups[frame][kJointGroups + contact.joint] = 1;
  }
  if (f.constraints.path.defined()) {
    const Baseline straight = baseline_of(poses, groups, {}, noise);
    const auto path = f.constraints.path.accessor<float, 2>();
    auto move = moves.accessor<float, 2>();
    for (int64_t frame = window.known + 1; frame <= window.last; ++frame) {
      if (path[frame][2] == 0) continue;
      const Eigen::Vector3f& root = straight.poses.root(frame - window.first);
      move[frame - window.first][0] = path[frame][0] - root.x();
      move[frame - window.first][1] = path[frame][1] - root.z();
    }
  }
  Baseline out = baseline_of(poses, groups, moves, noise);
  if (!f.config().along_detours) out.legs = {};
  return out;
}

/// What a network of residual motion says of a window.
Clip predict_residual(Filling& f, const FillWindow& window, const std::function<void(int64_t)>& progress,
                      uint64_t seed) {
  const Config& c = f.config();
  std::vector<int64_t> frames(static_cast<size_t>(c.frames));
  for (size_t i = 0; i < frames.size(); ++i)
    frames[i] = std::min(window.first + static_cast<int64_t>(i), f.last_frame());
  const Clip keys = frames_at(f.motion, frames);
  const Baseline baseline = baseline_of_window(f, window, keys, seed);
  if (f.options.stage == Stage::baseline) return clip_of(baseline.poses, keys, f.floor);
  ResidualSampling how{f.schedule, f.options.sampler, f.steps, c.inference.guidance};
  how.noise = with_temperature(seeded_noise(1, kResidualFeatures, c.frames, seed), f.temperature);
  how.progress = progress;
  const SampledMotion sampled = sample_residual(f.networks, f.denoiser, baseline, f.distances, how);
  if (sampled.feet.defined()) {
    if (!f.feet.defined()) f.feet = torch::zeros({f.motion.frames(), sampled.feet.size(1)});
    const int64_t from = window.first == 0 ? 0 : window.known + 1, to = window.last + 1;
    f.feet.slice(0, from, to).copy_(sampled.feet.slice(0, from - window.first, to - window.first));
  }
  return clip_of(sampled.poses, keys, f.floor);
}

}  // namespace

void fill_window(Filling& f, const std::vector<FillWindow>& windows, size_t w) {
  const Config& c = f.config();
  const FillWindow& window = windows[w];
  const auto progress = [&](int64_t done) {
    if (f.options.progress)
      f.options.progress(static_cast<int64_t>(w) * f.steps + done, static_cast<int64_t>(windows.size()) * f.steps);
  };
  const uint64_t seed = item_seed(f.options.seed, w);
  const Clip predicted =
      c.residual ? predict_residual(f, window, progress, seed) : predict_features(f, window, progress, seed);
  Clip refined = slice(predicted, 0, window.last + 1 - window.first);
  // Residual motion meets whole keys by itself.
  const bool open = f.options.key_groups.defined() || !f.constraints.contacts.empty() || f.constraints.path.defined();
  if (f.options.stage == Stage::finished && (open || !c.residual)) {
    refine::GeneratedOptions refining;
    // Noise of dense keys passes through the network as jitter; between sparse ones there is none to be smoothed away.
    refining.smooth = c.t_star > 0 && f.last_frame() <= kDenseKeys * static_cast<int64_t>(f.keys.size() - 1);
    refined = refine::refine_generated(refined, key_poses(f, window, refined), refining);
  }
  const int64_t from = w == 0 ? 0 : window.known + 1;
  const std::pair<Tensor&, Tensor&> parts[] = {
      {f.motion.joints, refined.joints}, {f.motion.rotations, refined.rotations}, {f.motion.trans, refined.trans}};
  // What the next window fills again keeps its noisy keys.
  const int64_t to = c.residual && w + 1 < windows.size() ? windows[w + 1].known : window.last;
  for (int64_t frame = from; frame <= to; ++frame) {
    if (c.residual && exact_key(f, frame)) continue;  // bit by bit
    for (const auto& [part, source] : parts) part[frame].copy_(source[frame - window.first]);
  }
}

}  // namespace inhabit::inbetween
