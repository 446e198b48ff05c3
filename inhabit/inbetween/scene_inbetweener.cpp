#include "inhabit/inbetween/scene_inbetweener.h"

#include <utility>

#include "inhabit/body/body_model.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/conditioning.h"
#include "inhabit/inbetween/fast_denoiser.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/reach.h"
#include "inhabit/inbetween/sample.h"
#include "inhabit/inbetween/way_around.h"
#include "inhabit/inbetween/windows.h"
#include "inhabit/math/random.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/feet.h"
#include "inhabit/scene/basis_points.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr int64_t kOverlap = 60;      // frames of a window that the one before filled (supplement 8.2)
constexpr int64_t kLeastOverlap = 8;  // fewer do not tell how fast everything moves
constexpr int64_t kLead = 60;         // frames around a clean key that make up for what was missed of it
constexpr double kFootNoise = 0.05;   // metres from where a noisy key has it that a foot may be put, at least
constexpr int64_t kRedone = 8;        // of a noise-aware model: a window's last key is kept as noisy as it was given

void check(const Clip& clip, const Options& request, const Config& config) {
  if (clip.skeleton.parents != standard_parents() || !clip.rotations.defined() || !clip.trans.defined())
    throw Error("in-betweening", "needs rotations on the standard skeleton");
  if (std::abs(clip.rate - config.rate) > 1e-6)
    throw Error("in-betweening", "the clip has " + std::to_string(clip.rate) + " frames a second, the model " +
                                     std::to_string(config.rate));
  const auto& keys = request.keys;
  if (keys.size() < 2) throw Error("key frames", "fewer than two");
  if (keys.front() != 0 || keys.back() != clip.frames() - 1)
    throw Error("key frames", "the first and the last frame must be among them");
  for (size_t i = 1; i < keys.size(); ++i)
    if (keys[i] <= keys[i - 1]) throw Error("key frames", "are not in order");
  if (request.given.defined() && !config.partial_keys)
    throw Error("in-betweening", "this model takes whole key poses only");
  for (const Tensor& t : {clip.joints, clip.rotations, clip.trans})
    if (!t.index_select(0, torch::tensor(keys)).isfinite().all().item<bool>())
      throw Error("in-betweening", "a key pose is not finite");
}

}  // namespace

SceneInbetweener::SceneInbetweener(Networks networks)
    : networks_(std::move(networks)), schedule_(cosine_schedule(networks_.config.diffusion_steps)) {
  const int64_t anchors = builtin_body().anchors.size(0);
  if (config().local_scene && config().anchors != anchors)
    throw Error("in-betweening", "the model looks from " + std::to_string(config().anchors) +
                                     " anchors, the body has " + std::to_string(anchors));
  networks_.network->eval();
}

SceneInbetweener SceneInbetweener::load(const std::string& path) { return SceneInbetweener(load_networks(path)); }

Clip SceneInbetweener::fill(const Clip& clip, const Scene& scene, const Options& request) const {
  const torch::NoGradGuard no_gradients;
  const Config& c = config();
  check(clip, request, c);
  const auto windows = fill_windows(request.keys, c.frames, kOverlap, kLeastOverlap, c.t_star > 0 ? kRedone : 0);
  Denoiser network = networks_.network;
  FastDenoiser denoiser(network);
  const SceneQuery query(scene);
  Clip out = person_of(clip);
  out.joints = clip.joints.clone();
  out.rotations = clip.rotations.clone();
  out.trans = clip.trans.clone();
  const Clip key_poses = frames_at(clip, request.keys);
  out.betas = body_betas(key_poses);
  const double floor = floor_under(key_poses);
  const Tensor whole = torch::ones({kKeyGroups});
  const Tensor shape = body_shape_features(builtin_body(), out.betas).unsqueeze(0);
  for (size_t w = 0; w < windows.size(); ++w) {
    const FillWindow& window = windows[w];
    // What is given: the frames that stand already, then key frames. `out` has both.
    std::vector<int64_t> at;
    Tensor groups = torch::zeros({c.frames, kKeyGroups}), always = torch::zeros({c.frames});
    for (int64_t frame = window.first; frame <= window.known; ++frame) {
      at.push_back(frame);
      groups[frame - window.first].copy_(whole);
      always[frame - window.first].fill_(1);
    }
    for (const int64_t key : request.keys) {
      if (key <= window.known || key > window.last) continue;
      at.push_back(key);
      const bool end = key == clip.frames() - 1;
      groups[key - window.first].copy_(request.given.defined() && !end ? request.given : whole);
      if (key == window.last) always[key - window.first].fill_(1);
    }
    const Tensor places = torch::tensor(at) - window.first;
    const Clip poses = frames_at(out, at);
    GroundTransform to_canonical = canonical_transform(poses);
    to_canonical.shift.y() -= floor;
    const Tensor metres = clip_features(transformed(poses, to_canonical)),
                 features = networks_.scale.to_network(metres);
    Conditioning on;
    GivenFeatures& given = on.given;
    given.values = torch::zeros({1, kFeatureCount, c.frames}).index_copy_(2, places, features.t().unsqueeze(0));
    given.mask = feature_mask(groups).t().unsqueeze(0);
    given.always = given.mask * always;
    given.t_star = c.t_star;
    given.lead = 0;

    on.groups = groups.unsqueeze(0);
    on.shape = shape;
    on.detours = torch::zeros({1, c.frames, 2});
    if (c.global_scene) on.occupancy = scene_occupancy(query, poses.joints[0][0], -to_canonical.yaw).unsqueeze(0);
    Tensor offsets = torch::zeros({c.frames, c.anchors, 3});
    if (c.local_scene)
      offsets.index_copy_(0, places,
                          basis_point_offsets(query, anchor_positions(poses)).matmul(yaw_matrix(to_canonical.yaw).t()));
    on.offsets = offsets.permute({1, 2, 0}).unsqueeze(0);
    if (c.from_interpolation && c.around_obstacles && c.global_scene) {
      const Tensor root = torch::zeros({c.frames, 3}).index_copy_(0, places, metres.slice(1, 0, 3));
      const Tensor squares = scene_floor(query, poses.joints[0][0], -to_canonical.yaw, floor);
      on.detours = detours_around(squares, root, groups).unsqueeze(0);
    }
    const DenoiserInput in = denoiser_input(networks_, on);
    const auto denoise = [&](const Tensor& x, int64_t t) {
      if (c.global_scene)
        return in.baseline + denoiser.guided(x, in.mask, in.local, t, in.scene, in.shape, c.inference.guidance);
      return in.baseline + denoiser.forward(x, in.mask, in.local, torch::full({1}, t, torch::kInt64), in.shape);
    };
    const auto noise = seeded_noise(1, kFeatureCount, c.frames, item_seed(request.seed, w));
    const Tensor filled = sample(schedule_, request.sampler, request.steps, denoise, given, noise, [&](int64_t done) {
      if (request.progress)
        request.progress(static_cast<int64_t>(w) * request.steps + done,
                         static_cast<int64_t>(windows.size()) * request.steps);
    });
    const Tensor met = lead_poses_to_given(filled, given, kLead, networks_.scale);
    const Tensor found = networks_.scale.from_network(met[0].t());
    const Clip moved = transformed(clip_of_features(found, out), to_canonical.inverse());
    const int64_t from = w == 0 ? 0 : window.known + 1;
    for (auto [to, source] : {std::pair(out.joints, moved.joints), std::pair(out.rotations, moved.rotations),
                              std::pair(out.trans, moved.trans)})
      to.slice(0, from, window.last + 1).copy_(source.slice(0, from - window.first, window.last + 1 - window.first));
  }
  if (request.given.defined()) out = reach_given(out, clip, request.keys, request.given);
  if (request.clean_feet) {
    // Feet that keys between the ends give stay.
    const Tensor feet = torch::tensor({7, 8, 10, 11}) + kJointGroups;
    const bool met =
        c.t_star == 0 && (!request.given.defined() || request.given.index_select(0, feet).any().item<bool>());
    std::vector<int64_t> fixed = met ? request.keys : std::vector<int64_t>{0, clip.frames() - 1}, near;
    double within = 0;
    if (c.t_star > 0 && !request.given.defined()) {
      near = request.keys;
      const Tensor missed = frames_at(out, near).joints - key_poses.joints;
      within = std::max(kFootNoise, 3 * missed.norm(2, {2}).mean().item<double>());
    }
    out = clean_feet(out, fixed, floor, near, within);
  }
  out.betas = clip.betas;
  return out;
}

}  // namespace inhabit::inbetween
