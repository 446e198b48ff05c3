#include "inhabit/inbetween/train.h"

#include <cmath>
#include <numeric>

#include "inhabit/error.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/losses.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/motion_autoencoder.h"
#include "inhabit/inbetween/sample.h"
#include "inhabit/inbetween/sampler.h"
#include "inhabit/inbetween/schedule.h"
#include "inhabit/inbetween/way_around.h"
#include "inhabit/math/random.h"
#include "inhabit/math/rotation.h"
#include "inhabit/nn/bfloat16.h"
#include "inhabit/train/stages.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr double kAverage = 0.9995;   // the paper's 0.9999 averages over as many
                                      // steps as a short run has in all
constexpr double kOpenEnds = 0.25;    // share of the windows whose last frame is not given
constexpr double kPartialKeys = 0.3;  // share of the windows some of whose keys are partial
constexpr double kAllPartial = 0.3;   // share of these in which all keys but the ends are
constexpr double kContinued = 0.3;    // share of the windows that go on from known frames, as those of long clips do
constexpr int kLeastKnown = 8, kMostKnown = 100;  // frames of these
constexpr int64_t kValidationWindows = 192;
constexpr double kLeastDeviation = 0.01, kLeastTurn = 0.1;  // metres, and of a rotation's 6D

// Places in a batch.
enum : size_t {
  kFeatures,   // (B, 201, T) standardised
  kOccupancy,  // (B, 24, 48, 48)
  kSceneKept,  // (B) 1, or 0 where the global scene is hidden
  kOffsets,    // (B, 64, 3, T)
  kShape,      // (B, 7)
  kBones,      // (B, 22, 3)
  kKeys,       // (B, 201, T) standardised key poses, noisy where the network is to be
               // aware of noise
  kGroups,     // (B, T, 25) 1 for what is given of a frame
  kEnds,       // (B, T) 1 at the first and the last key frame and at known frames
  kWays,       // (B, T, 2) metres that the straight way between key frames is left by
  kSteps,      // (B) diffusion steps
  kNoise       // (B, 201, T)
};

/// What is given of a window.
struct Keys {
  Tensor groups;  // (T, 25)
  Tensor ends;    // (T) 1 at the first and the last key frame, and at frames that are known
};

/// The number of key frames is drawn evenly from the paper's {2, ..., T} and,
/// every second time, evenly in its logarithm: keys far apart, which users
/// mostly have, are rare in the first. Some windows end in frames of no key, as
/// a clip shorter than a window does.
Keys draw_keys(int64_t frames, bool partial, std::mt19937_64& random) {
  const auto count = static_cast<double>(frames);
  const double n =
      chance(random, 0.5) ? uniform(random, 2, count + 1) : std::exp(uniform(random, std::log(2.), std::log(count)));
  const int last = chance(random, kOpenEnds)
                       ? uniform_int(random, static_cast<int>(frames / 8), static_cast<int>(frames) - 2)
                       : static_cast<int>(frames) - 1;
  Keys out{torch::zeros({frames, kKeyGroups}), torch::zeros({frames})};
  for (const int end : {0, last}) {
    out.groups[end].fill_(1);
    out.ends[end].fill_(1);
  }
  // The same joints in all partial keys of a window, as somebody gives them who
  // draws a hand's path.
  const bool some_partial = partial && chance(random, kPartialKeys);
  const double share = chance(random, kAllPartial) ? 1 : uniform(random, 0, 1);
  Tensor given = torch::zeros({kKeyGroups});
  if (some_partial) {
    const int joints = uniform_int(random, 0, 4);
    for (int j = 0; j < joints; ++j) given[kJointGroups + uniform_int(random, 0, kStandardJoints - 1)] = 1;
    if (joints == 0 || chance(random, 0.5)) given[kJointGroups] = 1;  // the pelvis
    given[kRootTranslationGroup] = given[kJointGroups];
  }
  std::vector<int> inner(static_cast<size_t>(std::max(0, last - 1)));
  std::iota(inner.begin(), inner.end(), 1);
  const size_t wanted = std::min(inner.size(), static_cast<size_t>(std::max(0.0, n * last / count - 2)));
  for (size_t i = 0; i < wanted; ++i) {
    std::swap(inner[i],
              inner[static_cast<size_t>(uniform_int(random, static_cast<int>(i), static_cast<int>(inner.size()) - 1))]);
    out.groups[inner[i]].copy_(some_partial && chance(random, share) ? given : torch::ones({kKeyGroups}));
  }
  if (chance(random, kContinued)) {
    const int known = std::min(last, uniform_int(random, kLeastKnown, kMostKnown));
    for (Tensor* given_frames : {&out.groups, &out.ends}) given_frames->slice(0, 0, known).fill_(1);
  }
  return out;
}

struct Standard {
  Tensor mean, deviation;  // (201)
  Tensor operator()(const Tensor& features) const { return (features - mean) / deviation; }
};

Batch make_batch(const Data& data, const Config& c, const Standard& standard, const std::vector<int64_t>& indices,
                 uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Tensor> features, occupancy, offsets, shape, bones, keys, groups, ends, ways;
  std::vector<int64_t> steps;
  std::vector<float> kept;
  for (const int64_t index : indices) {
    Sample s = data.sample(index);
    if (c.rest_turn > 0) {
      auto turns = at::detail::createCPUGenerator(random());
      const double deviation = uniform(random, 0, c.rest_turn) * M_PI / 180;
      s.features = with_rest_turned(
          s.features, axis_angle_to_matrix(torch::randn({kStandardJoints, 3}, turns) * deviation), s.bones);
    }
    features.push_back(standard(s.features).t());
    occupancy.push_back(s.occupancy);
    offsets.push_back(s.offsets.permute({1, 2, 0}));
    shape.push_back(s.body_shape);
    bones.push_back(s.bones);
    const Keys drawn = draw_keys(c.frames, c.partial_keys, random);
    groups.push_back(drawn.groups);
    ends.push_back(drawn.ends);
    Tensor given = s.features;
    if (c.t_star > 0)
      given = torch::where(drawn.ends.unsqueeze(1) > 0, given,
                           noisy_features(given, s.bones, uniform(random, 0, 1), random));
    keys.push_back(standard(given).t());
    ways.push_back(c.around_obstacles && c.global_scene ? ways_around(s.floor, given.slice(1, 0, 3), drawn.groups)
                                                        : torch::zeros({c.frames, 2}));
    steps.push_back(uniform_int(random, 0, c.diffusion_steps - 1));
    kept.push_back(chance(random, c.scene_dropout) ? 0.F : 1.F);
  }
  auto generator = at::detail::createCPUGenerator(random());
  const Tensor noise = torch::randn({static_cast<int64_t>(indices.size()), kFeatureCount, c.frames}, generator);
  return {torch::stack(features), torch::stack(occupancy), torch::tensor(kept),  torch::stack(offsets),
          torch::stack(shape),    torch::stack(bones),     torch::stack(keys),   torch::stack(groups),
          torch::stack(ends),     torch::stack(ways),      torch::tensor(steps), noise};
}

/// What the network makes of a batch, in float32. @param between the keys' interpolation where the network sees it.
Tensor predict(const Networks& networks, const Batch& b, const Tensor& x, const Tensor& between, bool bfloat16) {
  const Config& c = networks.config;
  Denoiser network = networks.network;
  const Bfloat16Products products(bfloat16);
  Tensor embedding = torch::zeros({x.size(0), c.width});
  if (c.global_scene) embedding = embedding + network->embed_scene(b[kOccupancy]) * b[kSceneKept].unsqueeze(1);
  if (c.body_shape) embedding = embedding + network->embed_shape(b[kShape]);
  Tensor local = network->embed_offsets(b[kOffsets], b[kGroups].amin(2));  // offsets need the whole pose
  if (between.defined()) local = torch::cat({local, between}, 1);
  const Tensor mask = c.partial_keys ? b[kGroups].transpose(1, 2) : b[kGroups].amax(2).unsqueeze(1);
  return network->forward(x, mask, local, b[kSteps], embedding).to(torch::kFloat32);
}

Losses losses_of(const Networks& networks, const DiffusionSchedule& schedule, const Batch& b, bool bfloat16) {
  const Config& c = networks.config;
  const Tensor noisy = diffuse(schedule, b[kFeatures], b[kSteps], b[kNoise]);
  GivenFeatures given;
  given.values = b[kKeys];
  given.mask = feature_mask(b[kGroups]).transpose(1, 2);
  given.always = given.mask * b[kEnds].unsqueeze(1);
  given.t_star = c.t_star;
  const Tensor x = impute(noisy, given, b[kSteps]);
  const Tensor between = c.from_interpolation
                             ? along_ways(interpolate_given_poses(given, networks.mean, networks.deviation), b[kWays],
                                          given.mask, networks.deviation)
                             : Tensor();
  Tensor predicted = predict(networks, b, x, between, bfloat16);
  if (between.defined()) predicted = predicted + between;
  return loss_terms(predicted, b[kFeatures], b[kBones], networks.mean, networks.deviation, c);
}

/// Mean and deviation of every feature over `data`; at least kLeastDeviation, as the first root stands at the origin in
/// every window, and kLeastTurn for rotations, as joints that hardly turn here do so elsewhere.
Standard feature_standard(const Data& data) {
  Tensor sum = torch::zeros({kFeatureCount}, torch::kFloat64), squares = torch::zeros_like(sum);
  int64_t frames = 0;
  const int64_t stride = std::max<int64_t>(1, data.size() / 1000);
  for (int64_t i = 0; i < data.size(); i += stride) {
    const Tensor f = data.features(i).to(torch::kFloat64);
    sum += f.sum(0);
    squares += f.square().sum(0);
    frames += f.size(0);
  }
  const Tensor mean = sum / frames;
  Tensor deviation = (squares / frames - mean.square()).clamp_min(0).sqrt().clamp_min(kLeastDeviation);
  deviation.slice(0, kOrientFeature, kJointFeature).clamp_min_(kLeastTurn);
  return {mean.to(torch::kFloat32), deviation.to(torch::kFloat32)};
}

/// Joints (N, T, 22, 3) of all windows of a split.
Tensor window_joints(const Data& data) {
  std::vector<Tensor> out;
  for (int64_t i = 0; i < data.size(); ++i)
    out.push_back(data.features(i).slice(1, kJointFeature).reshape({-1, kStandardJoints, 3}));
  return torch::stack(out);
}

/// Copies the weights of a network that sees at least as much.
void adopt_weights(DenoiserImpl& network, const DenoiserImpl& start, const std::string& file) {
  const torch::NoGradGuard no_gradients;
  const auto parameters = start.named_parameters();
  const int64_t at = kFeatureCount + network.config.mask_channels();  // where the offsets' channels come in
  const bool no_offsets = start.config.local_scene && !network.config.local_scene;
  for (auto& p : network.named_parameters()) {
    const Tensor* found = parameters.find(p.key());
    Tensor value = found != nullptr ? *found : Tensor();
    if (found != nullptr && no_offsets && value.dim() == 3 && value.size(1) == p.value().size(1) + kLocalChannels)
      value = torch::cat({value.slice(1, 0, at), value.slice(1, at + kLocalChannels)}, 1);
    if (found == nullptr || value.sizes() != p.value().sizes())
      throw Error(file, "is of another configuration than this training");
    p.value().copy_(value);
  }
}

void require_windows(const Training& options, const Data& train, const Data& validation) {
  if (train.size() == 0 || validation.size() == 0)
    throw Error(options.data.front(), "has no window of " + std::to_string(options.config.frames) +
                                          " frames in a scene in its split " + (train.size() == 0 ? "train" : "val"));
}

/// False when it was interrupted.
bool run(const TrainTask& task, const Training& options, size_t first) {
  TrainOptions loop = stage_options(options.out, 0, first, options.resume);
  loop.steps = options.steps;
  loop.batch = options.batch;
  loop.learning_rate = options.learning_rate;
  loop.validate_every = std::max<int64_t>(1, loop.steps / 20);
  loop.seed = options.seed;
  return !train(task, loop).interrupted;
}

}  // namespace

bool train_motion_features(const Training& options) {
  const size_t first = first_stage(options.out, {"motion_features"}, options.resume);
  const Data data(options.data, "train", options.config, options.stride),
      validation(options.data, "val", options.config, options.config.frames);
  require_windows(options, data, validation);
  torch::manual_seed(options.seed);
  MotionAutoencoder network;
  TrainTask task = motion_autoencoder_task(network, window_joints(data), window_joints(validation));
  task.name = "motion_features";
  task.on_best = [&] { save_motion_autoencoder(options.out, network); };
  return run(task, options, first);
}

bool train(const Training& options) {
  const Config& config = options.config;
  validate(config, options.out);
  const size_t first = first_stage(options.out, {"denoiser"}, options.resume);
  const Data data(options.data, "train", config, options.stride),
      validation(options.data, "val", config, config.frames);
  require_windows(options, data, validation);
  torch::manual_seed(options.seed);
  Networks networks;
  networks.config = config;
  networks.network = Denoiser(config);
  Standard standard;
  if (options.from.empty()) {
    standard = feature_standard(data);
  } else {
    const Networks start = load_networks(options.from);
    adopt_weights(*networks.network, *start.network, options.from);
    standard = {start.mean, start.deviation};
  }
  networks.mean = standard.mean;
  networks.deviation = standard.deviation;
  const DiffusionSchedule schedule = cosine_schedule(config.diffusion_steps);

  TrainTask task;
  task.name = "denoiser";
  task.settings = to_json(config) + (options.from.empty() ? "" : " from " + options.from);
  task.average = kAverage;
  task.weight_decay = 1e-2;
  task.module = networks.network.ptr();
  task.samples = data.size();
  task.prepare = [&](const std::vector<int64_t>& indices, uint64_t seed) {
    return make_batch(data, config, standard, indices, seed);
  };
  task.losses = [&](const Batch& batch) { return losses_of(networks, schedule, batch, options.bfloat16); };
  // The geometric mean over windows: in the plain one, single windows whose 6D rotations flip outweigh all others.
  task.validate = [&] {
    const int64_t windows = std::min(kValidationWindows, validation.size());
    double sum = 0;
    for (int64_t i = 0; i < windows; ++i) {  // spread over the whole split
      const Batch window = make_batch(validation, config, standard, {i * validation.size() / windows},
                                      item_seed(options.seed, static_cast<uint64_t>(i)));
      sum += std::log(losses_of(networks, schedule, window, false).front().second.item<double>());
    }
    return std::exp(sum / static_cast<double>(windows));
  };
  task.on_best = [&] { save_networks(options.out, networks, options.half); };
  return run(task, options, first);
}

}  // namespace inhabit::inbetween
