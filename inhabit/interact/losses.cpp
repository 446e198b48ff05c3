#include "inhabit/interact/losses.h"

#include "inhabit/interact/features.h"

namespace inhabit::interact {
namespace {

constexpr int64_t kPathSize = int64_t{6} * kFuturePoints;

/// Points (..., 2, 7, 3) of a control signal.
torch::Tensor points_of(const torch::Tensor& control) {
  return control.slice(-1, 0, kPathSize).unflatten(-1, {2, kFuturePoints, 3});
}
torch::Tensor phases_of(const torch::Tensor& control) {
  return control.slice(-1, kPathSize).unflatten(-1, {2, kFuturePoints});
}

}  // namespace

torch::Tensor frame_loss(const OutputLayout& layout, const torch::Tensor& output, const torch::Tensor& target,
                         double hand_weight, double linear_from) {
  const torch::Tensor off = (output - target).abs();
  const torch::Tensor errors = torch::where(off < linear_from, off.square(), linear_from * (2 * off - linear_from));
  if (hand_weight == 1) return errors.mean();
  constexpr int64_t kNumbers = 12, kLeftWrist = 20;  // of a joint
  torch::Tensor weight = torch::ones({layout.size}, errors.options());
  weight.slice(0, layout.joints.first + kNumbers * kLeftWrist, layout.joints.end()).fill_(hand_weight);
  return (errors * weight).sum() / (weight.sum() * errors.size(0));
}

ControlLosses control_losses(const torch::Tensor& output, const torch::Tensor& control, const torch::Tensor& target,
                             const torch::Tensor& wanted, const Config::Training& weights) {
  const torch::Tensor count = wanted.sum().clamp_min(1);
  const auto mean = [&](const torch::Tensor& errors) { return (errors * wanted).sum() / count; };  // (..., 2)
  const torch::Tensor points = points_of(output), truth = points_of(target);
  ControlLosses out;
  out.trajectory = mean((points - truth).square().sum(-1).mean(-1));
  out.phase = mean((phases_of(output) - phases_of(target)).square().mean(-1));
  out.straight = mean((points - points_of(control)).square().sum(-1).mean(-1));
  out.first = mean((points.select(-2, 0) - truth.select(-2, 0)).square().sum(-1));
  out.total = weights.trajectory_weight * out.trajectory + weights.phase_weight * out.phase +
              weights.straight_weight * out.straight + weights.first_point_weight * out.first;
  return out;
}

torch::Tensor next_lines(const torch::Tensor& output, const torch::Tensor& rotation) {
  const torch::Tensor first = points_of(output).select(-2, 0);  // (..., 2, 3)
  const torch::Tensor c = rotation.select(-1, 0).unsqueeze(-1), s = rotation.select(-1, 1).unsqueeze(-1);
  const torch::Tensor x = first.select(-1, 0), z = first.select(-1, 2);
  const torch::Tensor rotated = torch::stack({c * x + s * z, first.select(-1, 1), c * z - s * x}, -1);
  const torch::Tensor left = torch::arange(kFutureKeys, -1, -1, output.options()) / kFutureKeys;  // of the line
  return (rotated.unsqueeze(-2) * left.unsqueeze(-1)).flatten(-3);
}

ControlRun run_control(ControlNetwork& network, const ControlSequences& s, double own) {
  const int64_t frames = s.pose.size(0), batch = s.pose.size(1);
  ControlState state = network->start(batch);
  if (own <= 0) {
    const torch::Tensor output = network->forward(s.pose, s.control, state);
    return {s.control, output};
  }
  std::vector<torch::Tensor> control, output;
  for (int64_t t = 0; t < frames; ++t) {
    torch::Tensor in = s.control[t];
    if (t > 0) {
      const torch::Tensor chosen = (torch::rand({batch, 2}, in.options()) < own).to(in.dtype()) * s.again[t];
      const torch::Tensor lines = next_lines(output.back().detach(), s.rotation[t]).unflatten(-1, {2, kPathSize / 2});
      const torch::Tensor true_lines = in.slice(-1, 0, kPathSize).unflatten(-1, {2, kPathSize / 2});
      in = torch::cat({torch::where(chosen.unsqueeze(-1) > 0, lines, true_lines).flatten(-2), in.slice(-1, kPathSize)},
                      -1);
    }
    control.push_back(in);
    output.push_back(network->step(s.pose[t], in, state));
  }
  return {torch::stack(control), torch::stack(output)};
}

ContactLosses contact_losses(ContactNetwork& network, const ContactRows& rows, const torch::Tensor& noise,
                             double beta) {
  const nn::LatentDistribution z = network->encode(rows.contacts, rows.chair);
  const torch::Tensor apart = (network->decode(z.sample(noise), rows.chair) - rows.contacts).unflatten(-1, {2, 3});
  ContactLosses out;
  out.distance = (apart.square().sum(-1) + 1e-10).sqrt().mean();
  out.divergence = z.divergence();
  out.total = out.distance + beta * out.divergence;
  return out;
}

}  // namespace inhabit::interact
