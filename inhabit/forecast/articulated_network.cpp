#include "inhabit/forecast/articulated_network.h"

#include <algorithm>
#include <string>

#include "inhabit/body/skeleton.h"
#include "inhabit/error.h"
#include "inhabit/math/dct.h"
#include "inhabit/math/rotation.h"

namespace inhabit::forecast {

namespace tn = torch::nn;
using torch::Tensor;

namespace {

constexpr double kTwistDamping = 1e-4;  // m^2: a rotation about a bone of 0.1 m that no other bone shows stays 0
constexpr double kLongDamping = 1e-6;   // of the trace: of bones so long that float32 would lose the other

/// The standard skeleton's bones, one to each joint but the root, and the joints that rotate them.
struct Bones {
  Tensor parents, children;  // (21) joints at their ends
  Tensor rotators;           // (21) which of the rotating joints is the parent
  Tensor of_rotator;         // (17, 21) 1 where the joint rotates the bone
  Tensor chains;             // (21, 22) 1 where the bone lies between the root and the joint
  int64_t count = 0;         // rotating joints: 17
};

Bones make_bones() {
  const std::vector<int>& parents = standard_parents();
  std::vector<int64_t> parent, child, rotator, rotating;
  for (int j = 1; j < kStandardJoints; ++j) {
    parent.push_back(parents[j]);
    child.push_back(j);
  }
  for (int j = 0; j < kStandardJoints; ++j)
    if (std::find(parent.begin(), parent.end(), j) != parent.end()) rotating.push_back(j);
  for (const int64_t p : parent) rotator.push_back(std::find(rotating.begin(), rotating.end(), p) - rotating.begin());
  Bones out;
  out.count = static_cast<int64_t>(rotating.size());
  out.parents = torch::tensor(parent);
  out.children = torch::tensor(child);
  out.rotators = torch::tensor(rotator);
  out.of_rotator = torch::zeros({out.count, kStandardJoints - 1});
  out.chains = torch::zeros({kStandardJoints - 1, kStandardJoints});
  for (int j = 1; j < kStandardJoints; ++j) {
    out.of_rotator[rotator[j - 1]][j - 1] = 1;
    for (int k = j; k > 0; k = parents[k]) out.chains[k - 1][j] = 1;
  }
  return out;
}

const Bones& bones() {
  static const Bones all = make_bones();
  return all;
}

/// Bones (..., 21, 3) of joints (..., 22, 3).
Tensor bones_of(const Tensor& joints) {
  const int64_t dim = joints.dim() - 2;
  return joints.index_select(dim, bones().children.to(joints.device())) -
         joints.index_select(dim, bones().parents.to(joints.device()));
}

/// Frames of velocity that are left after each of 1..T frames, where it dies away exponentially within `frames`.
Tensor dying_away(int64_t future, double frames) {
  return frames * (1 - torch::exp(-torch::arange(1, future + 1, torch::kFloat) / frames));
}

}  // namespace

Tensor angular_velocities(const Tensor& before, const Tensor& now) {
  const Tensor bone = bones_of(now), change = bone - bones_of(before), sums = bones().of_rotator.to(now.device());
  // Bones rotate by change = w x bone: normal equations sum(|b|^2 I - b b^T) w = sum(b x change).
  const Tensor length = bone.square().sum(-1, true).unsqueeze(-1), unit = torch::eye(3, now.options());
  const Tensor inertia = length * unit - bone.unsqueeze(-1) * bone.unsqueeze(-2);
  const Tensor sum = torch::einsum("ab,nbij->naij", {sums, inertia});
  const Tensor trace = sum.diagonal(0, -2, -1).sum(-1, true).unsqueeze(-1);
  const Tensor matrix = sum + (kTwistDamping + kLongDamping * trace) * unit;
  const Tensor moment = torch::einsum("ab,nbi->nai", {sums, torch::cross(bone, change, -1)});
  return torch::linalg_solve(matrix, moment);
}

Tensor posed_from(const Tensor& last, const Tensor& path, const Tensor& rotations) {
  const Tensor of_bones = rotations.index_select(2, bones().rotators.to(rotations.device()));  // (B, T, 21, 3, 3)
  const Tensor rotated = (of_bones * bones_of(last).unsqueeze(1).unsqueeze(3)).sum(-1);        // (B, T, 21, 3)
  const Tensor from_root =
      torch::matmul(rotated.transpose(2, 3), bones().chains.to(rotations.device()));  // (B, T, 3, 22)
  return from_root.transpose(2, 3) + path.unsqueeze(2);
}

Tensor contact_conditioning(int64_t batch, bool any, bool predicted) {
  return torch::tensor({any ? 1.F : 0.F, any && predicted ? 1.F : 0.F}).expand({batch, 2});
}

ArticulatedNetworkImpl::Block::Block(tn::Module& owner, const std::string& name, int64_t count, int64_t width)
    : token_norm(owner.register_module(name + "token_norm", tn::LayerNorm(tn::LayerNormOptions({width})))),
      channel_norm(owner.register_module(name + "channel_norm", tn::LayerNorm(tn::LayerNormOptions({width})))),
      tokens(owner.register_module(name + "tokens", tn::Linear(count, count))),
      widen(owner.register_module(name + "widen", tn::Linear(width, width))),
      narrow(owner.register_module(name + "narrow", tn::Linear(width, width))) {}

Tensor ArticulatedNetworkImpl::Block::forward(const Tensor& x, double dropout, bool training) {
  const Tensor across = torch::silu(tokens->forward(token_norm->forward(x).transpose(1, 2))).transpose(1, 2);
  const Tensor mixed = x + torch::dropout(across, dropout, training);
  const Tensor widened = torch::silu(widen->forward(channel_norm->forward(mixed)));
  return mixed + narrow->forward(torch::dropout(widened, dropout, training));
}

int64_t ArticulatedNetworkImpl::token_count(const Config& c) {
  return (c.past - 2) / c.articulated.stride + 1 + c.future / c.articulated.stride;
}

int64_t ArticulatedNetworkImpl::added_count() { return 3 + 6 * bones().count; }

ArticulatedNetworkImpl::ArticulatedNetworkImpl(const Config& given) : config(given) {
  validate(config, "forecast network");
  if (config.joints != kStandardJoints || config.root != 0)
    throw Error("forecast network", "the articulated decoder poses the standard 22 joints alone");
  const Config::Articulated& a = config.articulated;
  const int64_t pose = 3 * kStandardJoints, width = a.width;
  past_tokens_ = (config.past - 2) / a.stride + 1;
  future_tokens_ = config.future / a.stride;
  const int64_t count = token_count(config);
  motion_in = register_module("motion_in", tn::Linear(2 * pose, width));
  person_in = register_module("person_in", tn::Linear(pose + 2, width));
  contact_in = register_module("contact_in", tn::Linear(4 * kStandardJoints, width));
  place = register_parameter("place", torch::randn({count, width}) * 0.1);
  for (int b = 0; b < a.blocks; ++b) blocks.emplace_back(*this, "block" + std::to_string(b) + "_", count, width);
  out_norm = register_module("out_norm", tn::LayerNorm(tn::LayerNormOptions({width})));
  coefficients = register_module("coefficients", tn::Linear(count, a.coefficients));
  out = register_module("out", tn::Linear(width, added_count()));
  torch::NoGradGuard no_grad;
  out->weight.zero_();  // untrained, the forecast is the continuation
  out->bias.zero_();
  const double frames = a.gate * config.rate;
  gate_ = (1 - torch::exp(-torch::arange(1, config.future + 1, torch::kFloat) / frames)).square().unsqueeze(1);
  from_dct_ = idct_matrix(config.future, a.coefficients);
}

ArticulatedNetworkImpl::Seen ArticulatedNetworkImpl::continued(const Tensor& past) const {
  torch::NoGradGuard no_grad;
  const Tensor last = past.select(1, config.past - 1), before = past.select(1, config.past - 2);
  const Config::Articulated& a = config.articulated;
  const auto going_on = [&](double seconds) {
    return dying_away(config.future, seconds * config.rate).to(past.device());
  };
  Seen on;
  on.past = past;
  on.path = last.select(1, 0).unsqueeze(1) +
            (last - before).select(1, 0).unsqueeze(1) * going_on(a.root_continuation).view({1, -1, 1});
  const Tensor rotations =
      angular_velocities(before, last).unsqueeze(1) * going_on(a.pose_continuation).view({1, -1, 1, 1});
  on.rotations = matrix_to_rotation6d(axis_angle_to_matrix(rotations));
  return on;
}

Tensor ArticulatedNetworkImpl::tokens(const Tensor& past, const Tensor& going_on, const Tensor& contact_points,
                                      const Tensor& conditioning) {
  const int64_t P = config.past, stride = config.articulated.stride, first = P - 1 - stride * (past_tokens_ - 1);
  const Tensor last = past.slice(1, P - 1, P);
  const Tensor frames = local_pose(torch::cat({past, going_on}, 1), 0), now = local_pose(last, 0);
  // From frame `first`, every stride-th: the last observed frame is among them.
  const int64_t end = P + stride * future_tokens_;
  const Tensor places = frames.slice(1, first, end, stride);
  const Tensor velocity = (places - frames.slice(1, first - 1, end - 1, stride)) * config.rate;
  Tensor x = motion_in->forward(torch::cat({places - now, velocity}, 2).flatten(2));
  x = x + person_in->forward(torch::cat({now.flatten(1), conditioning}, 1)).unsqueeze(1) + place;
  const Tensor touched = contact_points.slice(1, stride - 1, stride * future_tokens_, stride);
  const Tensor flag = touched.narrow(3, 3, 1);
  // Where the joint would go if it went to the point that it touches.
  const Tensor contact = contact_in->forward(torch::cat({(touched.narrow(3, 0, 3) - last) * flag, flag}, 3).flatten(2));
  return torch::cat({x.slice(1, 0, past_tokens_), x.slice(1, past_tokens_) + contact}, 1);
}

ArticulatedNetworkImpl::Seen ArticulatedNetworkImpl::see(const Tensor& past, const Tensor& contact_points,
                                                         const Tensor& conditioning) {
  const int64_t batch = past.dim() == 4 ? past.size(0) : -1;
  if (batch < 0 || past.sizes().slice(1) != at::IntArrayRef({config.past, kStandardJoints, 3}) ||
      contact_points.sizes() != at::IntArrayRef({batch, config.future, kStandardJoints, 4}) ||
      conditioning.sizes() != at::IntArrayRef({batch, 2}))
    throw Error("forecast network: past, contact_points or conditioning has the wrong shape");
  Seen seen = continued(past);
  const Tensor last = past.select(1, config.past - 1);
  seen.tokens =
      tokens(past, posed_from(last, seen.path, rotation6d_to_matrix(seen.rotations)), contact_points, conditioning);
  for (Block& block : blocks) seen.tokens = block.forward(seen.tokens, config.training.dropout, is_training());
  return seen;
}

MotionForecast ArticulatedNetworkImpl::go_on(const Seen& seen, const Tensor& coefficients_added) const {
  const Tensor& past = seen.past;
  const Tensor added =
      torch::matmul(from_dct_.to(past.device()), coefficients_added) * gate_.to(past.device());  // (B, T, 105)
  const Tensor path = seen.path + added.narrow(2, 0, 3);
  const Tensor rotations = rotation6d_to_matrix(seen.rotations + added.slice(2, 3).view(seen.rotations.sizes()));
  const Tensor joints = posed_from(past.select(1, config.past - 1), path, rotations);
  return {torch::cat({past.select(2, 0), path}, 1), joints - path.unsqueeze(2)};
}

Tensor ArticulatedNetworkImpl::mean_coefficients(const Tensor& seen_tokens) {
  return out->forward(coefficients->forward(out_norm->forward(seen_tokens).transpose(1, 2)).transpose(1, 2));
}

MotionForecast ArticulatedNetworkImpl::forward(const Tensor& past, const Tensor& contact_points,
                                               const Tensor& conditioning) {
  const Seen seen = see(past, contact_points, conditioning);
  return go_on(seen, mean_coefficients(seen.tokens));
}

}  // namespace inhabit::forecast
