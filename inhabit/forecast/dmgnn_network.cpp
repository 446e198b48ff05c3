#include "inhabit/forecast/dmgnn_network.h"

#include <array>
#include <string>

#include "inhabit/body/skeleton.h"
#include "inhabit/error.h"
#include "inhabit/nn/batch_norm.h"

namespace inhabit::forecast {

namespace tn = torch::nn;
using torch::Tensor;

namespace {

// The released configuration's.
constexpr double kEncoderDropout = 0.5, kEmbeddingDropout = 0.2, kCellDropout = 0.3, kCellLeak = 0.1;
constexpr double kFromOtherScales = 0.3;    // of what scales tell each other behind the first two layers
constexpr double kFromCoarserScales = 0.6;  // of what the joints get of parts in the end
constexpr int64_t kTimeKernel = 5;          // frames
constexpr int64_t kLayers = 4;              // of each scale; joints have one more
constexpr int64_t kTelling = 2;             // layers behind which scales tell each other

using Groups = std::vector<std::vector<int>>;
using Edges = std::vector<std::pair<int, int>>;

BodyScale scale_of(const Groups& groups, const Edges& edges) {
  const auto count = static_cast<int64_t>(groups.size());
  BodyScale out;
  out.members = torch::zeros({count, kStandardJoints});
  for (int64_t g = 0; g < count; ++g) {
    const std::vector<int>& group = groups[static_cast<size_t>(g)];
    for (const int joint : group) out.members[g][joint] = 1.0 / static_cast<double>(group.size());
  }
  const Tensor self = torch::eye(count);
  Tensor others = torch::zeros({count, count});
  for (const auto& [a, b] : edges) others[a][b] = others[b][a] = 1;
  const Tensor degree = (self + others).sum(0, true);
  out.adjacency = torch::stack({self / degree, others / degree});
  return out;
}

/// Normalisation of (B, S, C) over everything but C.
Tensor normed(nn::BatchNorm& norm, const Tensor& x) { return norm->forward(x.transpose(1, 2)).transpose(1, 2); }

/// Convolution along a graph's edges, weighted as they are learned, then over five frames, with a residual beside both
/// unless it is the first.
struct GraphTimeConvImpl : tn::Module {
  GraphTimeConvImpl(const Tensor& adjacency, int64_t inputs, int64_t outputs, int64_t stride, bool first)
      : adjacency_(adjacency),
        edge_factor(register_parameter("edge_factor", torch::ones_like(adjacency))),
        edge_offset(register_parameter("edge_offset", torch::zeros_like(adjacency))),
        along(register_module("along", convolution(inputs, 2 * outputs, 1, 1))),
        in_norm(register_module("in_norm", nn::BatchNorm(outputs))),
        over_time(register_module("over_time", convolution(outputs, outputs, kTimeKernel, stride))),
        out_norm(register_module("out_norm", nn::BatchNorm(outputs))) {
    if (first || (inputs == outputs && stride == 1)) {
      same_ = !first;
      return;
    }
    beside = register_module("beside", convolution(inputs, outputs, 1, stride));
    beside_norm = register_module("beside_norm", nn::BatchNorm(outputs));
  }

  /// (B, inputs, T, S) -> (B, outputs, ceil(T / stride), S)
  Tensor forward(const Tensor& x) {
    const Tensor edges = adjacency_.to(x.device()) * edge_factor + edge_offset;
    const auto by_edge = along->forward(x).chunk(2, 1);
    const Tensor told = torch::matmul(by_edge[0], edges[0]) + torch::matmul(by_edge[1], edges[1]);
    Tensor out = out_norm->forward(over_time->forward(torch::relu(in_norm->forward(told))));
    out = torch::dropout(out, kEncoderDropout, is_training());
    if (same_) out = out + x;
    if (!beside.is_empty()) out = out + beside_norm->forward(beside->forward(x));
    return torch::relu(out);
  }

  static tn::Conv2d convolution(int64_t inputs, int64_t outputs, int64_t frames, int64_t stride) {
    return tn::Conv2d(
        tn::Conv2dOptions(inputs, outputs, {frames, 1}).stride({stride, 1}).padding({(frames - 1) / 2, 0}));
  }

  Tensor adjacency_, edge_factor, edge_offset;
  tn::Conv2d along;
  nn::BatchNorm in_norm;
  tn::Conv2d over_time;
  nn::BatchNorm out_norm;
  tn::Conv2d beside{nullptr};
  nn::BatchNorm beside_norm{nullptr};

 private:
  bool same_ = false;
};
TORCH_MODULE(GraphTimeConv);

/// Two layers with what came in beside the first one's output, as the released network has them everywhere here.
struct ShortMlpImpl : tn::Module {
  ShortMlpImpl(int64_t inputs, int64_t hidden, bool activated)
      : first(register_module("first", tn::Linear(inputs, hidden))),
        second(register_module("second", tn::Linear(hidden + inputs, hidden))),
        norm(register_module("norm", nn::BatchNorm(hidden))),
        activated_(activated) {}
  Tensor forward(const Tensor& x) {
    const Tensor hidden = torch::dropout(torch::leaky_relu(first->forward(x)), kEmbeddingDropout, is_training());
    const Tensor out = normed(norm, second->forward(torch::cat({hidden, x}, 2)));
    return activated_ ? torch::leaky_relu(out) : out;
  }
  tn::Linear first, second;
  nn::BatchNorm norm;

 private:
  bool activated_;
};
TORCH_MODULE(ShortMlp);

/// Codes of the parts of one scale, by which they are compared with those of another.
struct PartCodesImpl : tn::Module {
  PartCodesImpl(int64_t channels, int64_t frames, int64_t hidden)
      : over_time(register_module("over_time", GraphTimeConvImpl::convolution(channels, channels, kTimeKernel, 2))),
        time_norm(register_module("time_norm", nn::BatchNorm(channels))),
        part(register_module("part", ShortMlp(channels * ((frames + 1) / 2), hidden, true))),
        pair(register_module("pair", ShortMlp(2 * hidden, hidden, true))),
        out(register_module("out", ShortMlp(2 * hidden, hidden, false))) {}
  /// (B, C, T, S) -> (B, S, hidden)
  Tensor forward(const Tensor& x) {
    const int64_t parts = x.size(3);
    const Tensor seen = torch::dropout(time_norm->forward(over_time->forward(x)), kEmbeddingDropout, is_training());
    const Tensor code = part->forward(seen.permute({0, 3, 2, 1}).flatten(2));
    // What every part (row) is told by every other one (column): its own code, and how much it differs.
    const Tensor own = code.unsqueeze(2).expand({-1, -1, parts, -1}), differs = own - code.unsqueeze(1);
    const Tensor told =
        pair->forward(torch::cat({own, differs}, 3).flatten(1, 2)).view({-1, parts, parts, code.size(2)});
    const Tensor others = (1 - torch::eye(parts, x.options())).view({1, parts, parts, 1});
    return out->forward(torch::cat({(told * others).sum(2) / static_cast<double>(parts), code}, 2));
  }
  tn::Conv2d over_time;
  nn::BatchNorm time_norm;
  ShortMlp part, pair, out;
};
TORCH_MODULE(PartCodes);

/// What parts of one scale are told by those of another: their features, mixed by how alike the codes of both are.
struct TellingImpl : tn::Module {
  TellingImpl(int64_t channels, int64_t frames, int64_t hidden)
      : telling(register_module("telling", PartCodes(channels, frames, hidden))),
        told(register_module("told", PartCodes(channels, frames, hidden))) {}
  /// Features (B, C, T, S) of one scale, told to another of (B, C, T, R).
  Tensor forward(const Tensor& from, const Tensor& to) {
    const Tensor alike = torch::matmul(told->forward(to), telling->forward(from).transpose(1, 2)).softmax(2);
    return torch::einsum("brs,bcts->bctr", {alike, from});
  }
  PartCodes telling, told;
};
TORCH_MODULE(Telling);

int64_t halved(int64_t frames, int64_t times) {
  for (int64_t i = 0; i < times; ++i) frames = (frames + 1) / 2;
  return frames;
}

}  // namespace

std::vector<BodyScale> body_scales() {
  Groups joints;
  Edges bones;
  for (int j = 0; j < kStandardJoints; ++j) {
    joints.push_back({j});
    if (j > 0) bones.emplace_back(standard_parents()[static_cast<size_t>(j)], j);
  }
  // Thigh and foot of either leg, trunk, head, upper and lower half of either arm.
  const Groups halves = {{1, 4},   {7, 10},  {2, 5},   {8, 11},  {0, 3, 6, 9},
                         {12, 15}, {13, 16}, {18, 20}, {14, 17}, {19, 21}};
  const Groups limbs = {{1, 4, 7, 10}, {2, 5, 8, 11}, {0, 3, 6, 9, 12, 15}, {13, 16, 18, 20}, {14, 17, 19, 21}};
  return {scale_of(joints, bones),
          scale_of(halves, {{0, 1}, {2, 3}, {0, 4}, {2, 4}, {4, 5}, {4, 6}, {6, 7}, {4, 8}, {8, 9}}),
          scale_of(limbs, {{0, 2}, {1, 2}, {2, 3}, {2, 4}})};
}

struct DmgnnEncoderImpl : tn::Module {
  DmgnnEncoderImpl(const std::vector<BodyScale>& scales, int64_t frames, int64_t width) : scales_(scales) {
    const int64_t hidden = width << (kLayers - 1);
    for (size_t s = 0; s < scales.size(); ++s)
      for (int64_t l = 0; l < kLayers; ++l)
        layers.push_back(register_module(
            "layer" + std::to_string(s) + "_" + std::to_string(l),
            GraphTimeConv(scales[s].adjacency, l == 0 ? 3 : width << (l - 1), width << l, l == 0 ? 1 : 2, l == 0)));
    last = register_module("last", GraphTimeConv(scales[0].adjacency, hidden, hidden, 1, false));
    for (int64_t l = 0; l < kTelling; ++l)
      for (int64_t pair = 0; pair < 4; ++pair)
        tellings.push_back(register_module("telling" + std::to_string(l) + "_" + std::to_string(pair),
                                           Telling(width << l, halved(frames, l), hidden)));
  }

  /// (B, 3, P, 22) -> (B, 22, hidden)
  Tensor forward(const Tensor& features) {
    std::array<Tensor, 3> x;
    for (size_t s = 0; s < x.size(); ++s) x[s] = torch::matmul(features, scales_[s].members.t().to(features.device()));
    for (int64_t l = 0; l < kLayers; ++l) {
      for (size_t s = 0; s < x.size(); ++s) x[s] = layers[s * kLayers + static_cast<size_t>(l)]->forward(x[s]);
      if (l >= kTelling) continue;
      Telling* tell = &tellings[static_cast<size_t>(l) * 4];
      const Tensor to_halves = tell[0]->forward(x[0], x[1]), to_joints = tell[1]->forward(x[1], x[0]);
      const Tensor to_limbs = tell[2]->forward(x[1], x[2]), from_limbs = tell[3]->forward(x[2], x[1]);
      x[0] = x[0] + kFromOtherScales * to_joints;
      x[1] = x[1] + kFromOtherScales * (to_halves + from_limbs);
      x[2] = x[2] + kFromOtherScales * to_limbs;
    }
    Tensor joints = x[0];
    for (size_t s = 1; s < x.size(); ++s) {
      const Tensor of_part = (scales_[s].members > 0).to(features.options());  // a joint gets what its part has
      joints = joints + kFromCoarserScales * torch::matmul(x[s], of_part);
    }
    return last->forward(joints).mean(2).transpose(1, 2);
  }

  std::vector<GraphTimeConv> layers;  // of each scale, one after the other
  GraphTimeConv last{nullptr};
  std::vector<Telling> tellings;  // behind each of the first layers: joints to halves, back, halves to limbs, back

 private:
  std::vector<BodyScale> scales_;
};

DmgnnNetworkImpl::DmgnnNetworkImpl(const Config& config) : future(config.future) {
  if (config.joints != kStandardJoints) throw Error("stage dmgnn", "needs the standard 22 joints");
  if (config.past < 3) throw Error("stage dmgnn", "needs three observed frames for accelerations");
  const std::vector<BodyScale> scales = body_scales();
  adjacency_ = scales[0].adjacency;
  const int64_t width = config.baselines.dmgnn_width, hidden = width << (kLayers - 1);
  for (const char* of : {"motion", "velocity", "acceleration"})
    encoders.push_back(
        register_module(std::string(of) + "_encoder", std::make_shared<DmgnnEncoderImpl>(scales, config.past, width)));
  start = register_module("start", tn::Linear(3 * hidden, hidden));
  edge_factor = register_parameter("edge_factor", torch::ones_like(adjacency_));
  edge_offset = register_parameter("edge_offset", torch::zeros_like(adjacency_));
  message = register_module("message", tn::Linear(hidden, 2 * hidden));
  motion_gates = register_module("motion_gates", tn::Linear(9, 3 * hidden));
  state_gates = register_module("state_gates", tn::Linear(tn::LinearOptions(hidden, 3 * hidden).bias(false)));
  const auto leaky = [] { return tn::LeakyReLU(tn::LeakyReLUOptions().negative_slope(kCellLeak)); };
  step = register_module(
      "step", tn::Sequential(tn::Linear(hidden, hidden), leaky(), tn::Dropout(kCellDropout), tn::Linear(hidden, hidden),
                             leaky(), tn::Dropout(kCellDropout), tn::Linear(hidden, 3)));
}

Tensor DmgnnNetworkImpl::forward(const Tensor& past) {
  const int64_t P = past.size(1);
  const auto change = [](const Tensor& x) {  // 0 in the first frame
    return torch::cat({torch::zeros_like(x.slice(1, 0, 1)), x.slice(1, 1) - x.slice(1, 0, x.size(1) - 1)}, 1);
  };
  const Tensor velocity = change(past), acceleration = change(velocity);
  std::vector<Tensor> codes;
  for (size_t i = 0; i < encoders.size(); ++i) {
    const Tensor features = i == 0 ? past : i == 1 ? velocity : acceleration;
    codes.push_back(encoders[i]->forward(features.permute({0, 3, 1, 2})));
  }
  Tensor state = torch::relu(start->forward(torch::cat(codes, 2)));  // (B, 22, hidden)
  const Tensor edges = (adjacency_.to(past.device()) * edge_factor + edge_offset).transpose(1, 2);
  Tensor place = past.select(1, P - 1), before = past.select(1, P - 2), moved = velocity.select(1, P - 2);
  std::vector<Tensor> out;
  for (int64_t t = 0; t < future; ++t) {
    const auto told = message->forward(state).chunk(2, 2);
    const Tensor heard = torch::matmul(edges[0], told[0]) + torch::matmul(edges[1], told[1]);
    const Tensor now = place - before;
    const auto seen = motion_gates->forward(torch::cat({place, now, now - moved}, 2)).chunk(3, 2);
    const auto known = state_gates->forward(heard).chunk(3, 2);
    const Tensor reset = torch::sigmoid(seen[0] + known[0]), keep = torch::sigmoid(seen[1] + known[1]);
    state = (1 - keep) * torch::tanh(seen[2] + reset * known[2]) + keep * state;
    before = place;
    moved = now;
    place = place + step->forward(state);
    out.push_back(place);
  }
  return torch::stack(out, 1);
}

}  // namespace inhabit::forecast
