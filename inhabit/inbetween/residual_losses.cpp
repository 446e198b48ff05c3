#include "inhabit/inbetween/residual_losses.h"

#include <cmath>

#include "inhabit/body/skeleton.h"
#include "inhabit/inbetween/residual_input.h"
#include "inhabit/inbetween/sampler.h"
#include "inhabit/nn/bfloat16.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr double kPlaceUnit = 0.1, kMoveUnit = 0.02, kInsideUnit = 0.05;  // metres; the second a frame
constexpr double kStanding = 0.008;                                       // metres a frame
constexpr double kLeastSwing = 0.08;                                      // metres a frame: a calm step's
constexpr double kLow = 0.05, kLowUnit = 0.01;                            // metres over the floor
constexpr double kBendUnit = 0.01, kJerkUnit = 0.01;                      // metres a frame^2 and a frame^3
constexpr double kSameStep = 0.1;                                         // metres between feet that take the same step
constexpr double kLeast = 0.05;  // of distances in these units, in the energy score

/// One evaluation of the denoiser. @param before (B, 135, T) what it predicted before. @param known set to its features
Tensor denoise(const Networks& networks, const ResidualBatch& b, const Tensor& x, const Tensor& before,
               const Tensor& steps, bool bfloat16, Tensor* known = nullptr) {
  Denoiser network = networks.network;
  const Tensor body = body_features(b.frames, b.scenes, before) * b.kept.view({-1, 1, 1});
  const Bfloat16Products products(bfloat16);
  const Tensor input = denoiser_channels(x, before, b.fixed, body);
  const Tensor features = network->features(input, steps, network->embed_shape(b.bones));
  if (known != nullptr) *known = features.to(torch::kFloat32);
  return network->unet->out_conv(features).to(torch::kFloat32) * b.open;
}

/// sqrt(1 + (distance / unit)^2) - 1 from the square of a distance: quadratic below the unit, linear beyond, so that a
/// few windows in which anything could happen do not outweigh the others.
Tensor robust(const Tensor& square, double unit) { return (1 + square / (unit * unit)).sqrt() - 1; }

Tensor mean_over(const Tensor& values, const Tensor& mask) { return (values * mask).sum() / mask.sum().clamp_min(1); }

/// Metres that points (B, T, P, 3) are nearer to obstacles than `room` (B, T, P), else 0.
Tensor nearer_than(const Tensor& room, const std::vector<SceneDistances>& scenes, const Tensor& points) {
  const ProbedPoints probed = probe(scenes, points);
  // The distance as it changes with the points: its value and its gradient are the field's.
  const Tensor distance = probed.distance + (probed.gradient * (points - points.detach())).sum(3);
  return (room - distance).clamp_min(0);
}

/// Joints as predicted and as they truly are, and where the two may differ.
struct Joints {
  Tensor here, there;   // (B, T, 22, 3) metres, world
  Tensor guarded;       // (B, T, 38, 3) guarded_points() as predicted
  Tensor open, moving;  // (B, T, 1) 1 between keys; (B, T - 1, 1) 1 where one of two frames is
};

Joints joints_of(const ResidualBatch& b, const Tensor& predicted) {
  Joints out;
  const Tensor joints = residual_joints(b.frames, predicted);
  out.here = to_world(b.frames, joints);
  out.guarded = to_world(b.frames, guarded_points(b.frames, predicted, joints));
  out.there = to_world(b.frames, residual_joints(b.frames, b.residual)).detach();
  out.open = b.open.select(1, 3).unsqueeze(2);
  out.moving = torch::maximum(out.open.slice(1, 1), out.open.slice(1, 0, -1));
  return out;
}

/// Speed of feet that stand in truth, squared.
Tensor feet_loss(const Joints& j) {
  const auto steps = [](const Tensor& joints) { return foot_positions(joints).diff(1, 1); };
  const Tensor standing = (steps(j.there).norm(2, 3) < kStanding).to(torch::kFloat32) * j.moving;
  return mean_over(steps(j.here).square().sum(3), standing) / (kMoveUnit * kMoveUnit);
}

/// Residuals (B, 135, T) as they are sampled in use. @param known set to the features of the last evaluation
Tensor sampled(const Networks& networks, const DiffusionSchedule& schedule, const ResidualBatch& b, bool bfloat16,
               Tensor* known = nullptr) {
  Tensor before = torch::zeros_like(b.residual);
  const auto predict = [&](const Tensor& x, int64_t t) {
    const Tensor clean = denoise(networks, b, x, before, torch::full_like(b.steps, t), bfloat16, known);
    before = clean.detach();
    return clean;
  };
  const KeyConstraints nothing_imposed{torch::zeros_like(b.open), 1 - b.open};
  const NoiseSource noise = [&](int64_t) { return b.noise; };
  return sample(schedule, Sampler::dpm_solver, networks.config.inference.steps, predict, nothing_imposed, noise, {});
}

}  // namespace

Losses denoising_losses(const Networks& networks, const DiffusionSchedule& schedule, const ResidualBatch& b,
                        bool bfloat16) {
  const Config::Training& weigh = networks.config.training;
  const Tensor x = diffuse(schedule, b.residual, b.steps, b.noise);
  Tensor before = torch::zeros_like(x);
  if (b.self_conditioned) {
    const torch::NoGradGuard no_gradients;
    before = denoise(networks, b, x, before, b.steps, bfloat16);
  }
  const Tensor predicted = denoise(networks, b, x, before, b.steps, bfloat16);
  const Tensor simple = mean_over((predicted - b.residual).square(), b.open);
  const Joints j = joints_of(b, predicted);
  const Tensor off = j.here - j.there;
  const Tensor square = off.square().sum(3);  // (B, T, 22)
  const Tensor joints = mean_over(robust(square, kPlaceUnit) * b.weights, j.open.expand_as(square));
  const Tensor drift = off.diff(1, 1).square().sum(3);
  const Tensor velocity = mean_over(robust(drift, kMoveUnit), j.moving.expand_as(drift));
  const Tensor feet = feet_loss(j), penetration = penetration_loss(b.scenes, j.guarded, b.room, b.kept);
  return {{"total", simple + weigh.joints_weight * joints + weigh.velocity_weight * velocity +
                        weigh.feet_weight * feet + weigh.penetration_weight * penetration},
          {"simple", simple},
          {"joints", joints},
          {"velocity", velocity},
          {"feet", feet},
          {"penetration", penetration},
          {"mm", mean_over(square.detach().sqrt(), j.open.expand_as(square)) * 1000}};
}

Tensor sliding_loss(const Tensor& joints, const Tensor& moving) {
  const Tensor feet = foot_positions(joints);
  const Tensor height = torch::minimum(feet.slice(1, 1), feet.slice(1, 0, -1)).select(3, 1);
  const Tensor low = torch::sigmoid((kLow - height) / kLowUnit);
  const Tensor fast = ((feet.diff(1, 1).square().sum(3) + 1e-8).sqrt() - kStanding).clamp_min(0);
  const Tensor slides = low * robust(fast.square(), kMoveUnit);
  return mean_over(slides, moving.expand_as(slides));
}

Tensor swinging_loss(const Tensor& joints, const Tensor& truth, const Tensor& moving) {
  const auto speed = [](const Tensor& of) { return (foot_positions(of).diff(1, 1).square().sum(3) + 1e-8).sqrt(); };
  const Tensor limit = speed(truth).amax({1, 2}, true).clamp_min(kLeastSwing);  // (B, 1, 1)
  const Tensor beyond = robust((speed(joints) - limit).clamp_min(0).square(), kMoveUnit);
  return mean_over(beyond, moving.expand_as(beyond));
}

Tensor penetration_loss(const std::vector<SceneDistances>& scenes, const Tensor& points, const Tensor& room,
                        const Tensor& kept) {
  const Tensor inside = (nearer_than(room, scenes, points) / kInsideUnit).square().sum(2).mean(1);  // (B)
  return mean_over(inside, kept);
}

Tensor clearance_loss(const std::vector<SceneDistances>& scenes, const Tensor& root, const Tensor& passes,
                      const Tensor& kept) {
  const Tensor nearer = nearer_than(passes, scenes, root_column(root));
  return mean_over(robust(nearer.square(), kPlaceUnit).mean({1, 2}), kept);
}

Tensor energy_score(const Tensor& a, const Tensor& b, const Tensor& truth, double least) {
  const auto apart = [&](const Tensor& p, const Tensor& q) {
    return ((p - q).square().sum(-1) + least * least).sqrt();
  };
  return 0.5 * (apart(a, truth) + apart(b, truth) - apart(a, b));
}

Losses contact_losses(const Networks& networks, const DiffusionSchedule& schedule, const ResidualBatch& b,
                      bool bfloat16) {
  FootContactNet feet = networks.feet;
  Tensor known, near;
  {
    const torch::NoGradGuard no_gradients;
    const Tensor predicted = sampled(networks, schedule, b, bfloat16, &known);
    const Joints j = joints_of(b, predicted);
    near = torch::exp(-foot_positions(j.here - j.there).norm(2, 3) / kSameStep);
  }
  const Tensor logits = feet(known).transpose(1, 2);  // (B, T, 4)
  const Tensor each = torch::nn::functional::binary_cross_entropy_with_logits(
      logits, b.feet, torch::nn::functional::BinaryCrossEntropyWithLogitsFuncOptions().reduction(torch::kNone));
  const Tensor right = ((logits.detach() > 0) == (b.feet > 0.5)).to(torch::kFloat32);
  return {{"total", mean_over(each, near)}, {"right", mean_over(right, near)}};
}

Losses deployed_losses(const Networks& networks, const DiffusionSchedule& schedule, const ResidualBatch& b,
                       bool bfloat16) {
  const Config& config = networks.config;
  const Tensor predicted = sampled(networks, schedule, b, bfloat16);
  const Joints j = joints_of(b, predicted);
  const int64_t half = b.residual.size(0) / 2;
  const auto score = [&](const Tensor& here, const Tensor& there, double unit, const Tensor& mask) {
    const Tensor each =
        energy_score(here.slice(0, 0, half) / unit, here.slice(0, half) / unit, there.slice(0, 0, half) / unit, kLeast);
    return mean_over(each, mask.slice(0, 0, half).expand_as(each));
  };
  const Tensor frames = score(predicted.transpose(1, 2), b.residual.transpose(1, 2), std::sqrt(kResidualFeatures),
                              j.open.squeeze(2)),
               joints = score(j.here, j.there, kPlaceUnit, j.open);
  Tensor moves = torch::zeros_like(frames), mask = j.open;
  Losses rates;
  Tensor here = j.here, there = j.there;
  for (const auto& [name, unit] :
       {std::pair{"velocity", kMoveUnit}, std::pair{"acceleration", kBendUnit}, std::pair{"jerk", kJerkUnit}}) {
    here = here.diff(1, 1);
    there = there.diff(1, 1);
    mask = torch::maximum(mask.slice(1, 1), mask.slice(1, 0, -1));
    rates.emplace_back(name, score(here, there, unit, mask));
    moves = moves + rates.back().second;
  }
  const Config::Training& weigh = config.training;
  const Tensor feet = feet_loss(j), slides = sliding_loss(j.here, j.moving),
               swings = swinging_loss(j.here, j.there, j.moving),
               penetration = penetration_loss(b.scenes, j.guarded, b.room, b.kept),
               clearance = clearance_loss(b.scenes, j.here.select(2, 0), b.passes, b.kept);
  Losses out = {
      {"total", frames + joints + moves + weigh.feet_weight * feet + weigh.sliding_weight * slides +
                    weigh.swinging_weight * swings + weigh.penetration_weight * penetration +
                    weigh.clearance_weight * clearance},
      {"frames", frames},
      {"joints", joints},
      {"feet", feet},
      {"slides", slides},
      {"swings", swings},
      {"penetration", penetration},
      {"clearance", clearance},
      {"mm", mean_over((j.here - j.there).detach().norm(2, 3), j.open.expand({-1, -1, kStandardJoints})) * 1000}};
  out.insert(out.end(), rates.begin(), rates.end());
  return out;
}

}  // namespace inhabit::inbetween
