#include "inhabit/inbetween/path_net.h"

#include <algorithm>
#include <cmath>

#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/nn/bfloat16.h"

namespace inhabit::inbetween {

namespace tn = torch::nn;
using Eigen::Vector2d;
using torch::Tensor;

namespace {

constexpr float kOccupied = 0.05F, kSeenFrom = 0.8F;  // metres: a map is 0 up to the one, 1 from the other on
constexpr int kMapLayers = 15;                        // heights from 0.25 to 1.65 m, 0.1 m apart
constexpr int64_t kFineChannels = 32, kMiddleChannels = 64, kCoarseChannels = 96, kTokenChannels = 64,
                  kFloorNormGroups = 8, kPathRounds = 3, kMixers = 2;
constexpr double kAround = 0.25;  // metres around a path's point that it sees the map at, too
constexpr int64_t kLooks = 9;     // places of the map that a point sees
constexpr int64_t kTimes = 6;     // numbers that tell its fraction of the time
constexpr double kUnit = 0.5;     // metres that the network counts in

/// A convolution and a group norm, which LibTorch has in float32 alone.
struct FloorConvolutionImpl : tn::Module {
  FloorConvolutionImpl(int64_t from, int64_t to, int64_t size, int64_t stride) {
    convolution =
        register_module("convolution", tn::Conv2d(tn::Conv2dOptions(from, to, size).stride(stride).padding(size / 2)));
    norm = register_module("norm", tn::GroupNorm(kFloorNormGroups, to));
  }
  Tensor forward(const Tensor& x) { return norm->forward(convolution->forward(x).to(torch::kFloat32)); }
  tn::Conv2d convolution{nullptr};
  tn::GroupNorm norm{nullptr};
};
TORCH_MODULE(FloorConvolution);

/// SiLU of x + convolutions(x).
struct FloorBlockImpl : tn::Module {
  explicit FloorBlockImpl(int64_t channels) {
    first = register_module("first", FloorConvolution(channels, channels, 3, 1));
    second = register_module("second", FloorConvolution(channels, channels, 3, 1));
  }
  Tensor forward(const Tensor& x) { return torch::silu(x + second->forward(torch::silu(first->forward(x)))); }
  FloorConvolution first{nullptr}, second{nullptr};
};
TORCH_MODULE(FloorBlock);

/// One layer of the mixer (B, 32, C): over the points of a path, then over channels.
struct PathMixerImpl : tn::Module {
  PathMixerImpl() {
    points = register_module("points", tn::Sequential(tn::Linear(kPathPoints, 2 * kPathPoints), tn::SiLU(),
                                                      tn::Linear(2 * kPathPoints, kPathPoints)));
    channels = register_module("channels", tn::Sequential(tn::Linear(kTokenChannels, 2 * kTokenChannels), tn::SiLU(),
                                                          tn::Linear(2 * kTokenChannels, kTokenChannels)));
    before_points = register_module("before_points", tn::LayerNorm(tn::LayerNormOptions({kTokenChannels})));
    before_channels = register_module("before_channels", tn::LayerNorm(tn::LayerNormOptions({kTokenChannels})));
  }
  Tensor forward(const Tensor& x) {
    const Tensor mixed =
        x + points->forward(before_points->forward(x).transpose(1, 2)).to(torch::kFloat32).transpose(1, 2);
    return mixed + channels->forward(before_channels->forward(mixed)).to(torch::kFloat32);
  }
  tn::Sequential points{nullptr}, channels{nullptr};
  tn::LayerNorm before_points{nullptr}, before_channels{nullptr};
};
TORCH_MODULE(PathMixer);

tn::Sequential down(int64_t from, int64_t to, int64_t size, int blocks) {
  tn::Sequential out(FloorConvolution(from, to, size, 2), tn::SiLU());
  for (int i = 0; i < blocks; ++i) out->push_back(FloorBlock(to));
  return out;
}

Tensor up(const Tensor& x) { return torch::upsample_nearest2d(x, {2 * x.size(2), 2 * x.size(3)}); }

/// (14, S): sines at fractions of the time.
Tensor sines_at(const Tensor& times) {
  return torch::sin(torch::arange(1, kPathSines + 1, times.options()).unsqueeze(1) * M_PI * times);
}

/// Where each cell is in the line's axes, in units of what the map reaches: (2, 48, 64).
Tensor cell_places() {
  const auto along = [](int64_t count) {
    return (2 * torch::arange(count, torch::kFloat32) + 1) / static_cast<double>(count) - 1;
  };
  return torch::stack(
      {along(kMapLong).expand({kMapWide, kMapLong}), along(kMapWide).unsqueeze(1).expand({kMapWide, kMapLong})});
}

/// The places around which a point sees the map: its own, and eight around it (9, 2), metres.
Tensor places_around() {
  std::vector<float> out = {0, 0};
  for (int i = 0; i < kLooks - 1; ++i)
    for (const double part : {std::cos(i * M_PI / 4), std::sin(i * M_PI / 4)})
      out.push_back(static_cast<float>(kAround * part));
  return torch::tensor(out).view({kLooks, 2});
}

}  // namespace

Vector2d PathLine::world(double u, double v) const {
  const Vector2d ahead = (to - from) / std::max(1e-9, length()), aside(ahead.y(), -ahead.x());
  return (from + to) / 2 + u * ahead + v * aside;
}

Vector2d path_map_point(int64_t across, int64_t along) {
  return kMapCell *
         Vector2d(static_cast<double>(along) + 0.5 - kMapLong / 2., static_cast<double>(across) + 0.5 - kMapWide / 2.);
}

Tensor path_map(const Tensor& distances) { return ((distances - kOccupied) / (kSeenFrom - kOccupied)).clamp(0, 1); }

float nearest_upright(const SceneDistances& scene, const Vector2d& place) {
  float nearest = kSeenFrom;
  for (int layer = 0; layer < kMapLayers; ++layer)
    nearest = std::min(nearest, scene.distance({static_cast<float>(place.x()), 0.25F + 0.1F * static_cast<float>(layer),
                                                static_cast<float>(place.y())}));
  return nearest;
}

bool line_blocked(const SceneDistances& scene, const PathLine& line) {
  const double inner = line.length() / 2 - kNearKeys;
  for (double u = -inner; u < inner; u += 0.05)
    if (nearest_upright(scene, line.world(u, 0)) < kWide) return true;
  return false;
}

Tensor path_map(const SceneDistances& scene, const PathLine& line) {
  Tensor distances = torch::empty({kMapWide, kMapLong});
  auto at = distances.accessor<float, 2>();
  for (int64_t across = 0; across < kMapWide; ++across)
    for (int64_t along = 0; along < kMapLong; ++along) {
      const Vector2d p = path_map_point(across, along);
      at[across][along] = nearest_upright(scene, line.world(p.x(), p.y()));
    }
  return path_map(distances);
}

Tensor path_offsets(const Tensor& sines, const Tensor& times) {
  return torch::matmul(sines, sines_at(times)).transpose(-1, -2);
}

Tensor path_places(const Tensor& sines, const Tensor& times, const Tensor& length) {
  const Tensor along = (times - 0.5) * length.unsqueeze(-1);
  const Tensor straight = torch::stack({along, torch::zeros_like(along)}, -1);
  return sines.defined() ? straight + path_offsets(sines, times) : straight;
}

Tensor path_times() { return (torch::arange(kPathPoints, torch::kFloat32) + 0.5) / static_cast<double>(kPathPoints); }

Tensor at_places(const Tensor& maps, const Tensor& places) {
  const Tensor reach = torch::tensor({kMapCell * kMapLong / 2, kMapCell * kMapWide / 2}).to(places.options());
  return tn::functional::grid_sample(
      maps, places / reach,
      tn::functional::GridSampleFuncOptions().mode(torch::kBilinear).padding_mode(torch::kBorder).align_corners(false));
}

PathNetImpl::PathNetImpl() {
  fine = register_module("fine", down(4, kFineChannels, 5, 1));
  middle = register_module("middle", down(kFineChannels, kMiddleChannels, 3, 2));
  coarse = register_module("coarse", down(kMiddleChannels, kCoarseChannels, 3, 2));
  back_to_middle =
      register_module("back_to_middle",
                      tn::Conv2d(tn::Conv2dOptions(kCoarseChannels + kMiddleChannels, kMiddleChannels, 3).padding(1)));
  back_to_fine = register_module(
      "back_to_fine", tn::Conv2d(tn::Conv2dOptions(kMiddleChannels + kFineChannels, kFineChannels, 3).padding(1)));
  constexpr int64_t kSquashed = 16, kHidden = 256;
  propose = register_module(
      "propose", tn::Sequential(tn::Conv2d(tn::Conv2dOptions(kCoarseChannels, kSquashed, 1)), tn::SiLU(), tn::Flatten(),
                                tn::Linear(kSquashed * (kMapWide / 8) * (kMapLong / 8), kHidden), tn::SiLU(),
                                tn::Linear(kHidden, kPathHypotheses * (2 * kPathSines + 1))));
  look = register_module("look", tn::Linear(kFineChannels + kLooks + 4 + kTimes + 1, kTokenChannels));
  mix = register_module("mix", tn::ModuleList());
  for (int64_t i = 0; i < kMixers; ++i) mix->push_back(PathMixer());
  move = register_module("move", tn::Linear(kTokenChannels, 2));
  const torch::NoGradGuard no_gradients;
  move->weight.mul_(0.1);
}

ProposedPaths PathNetImpl::forward(const Tensor& map, const Tensor& length) {
  const int64_t batch = map.size(0), tokens = batch * kPathHypotheses;
  const Tensor size = (length / 4).view({batch, 1, 1, 1}), own = map.unsqueeze(1);
  const Tensor cells = torch::cat({own, cell_places().to(map.device()).expand({batch, 2, kMapWide, kMapLong}),
                                   size.expand({batch, 1, kMapWide, kMapLong})},
                                  1);
  Tensor features, coarsest;
  {
    const Bfloat16Products products(bfloat16 && is_training());
    const Tensor f = fine->forward(cells), m = middle->forward(f);
    coarsest = coarse->forward(m);
    const Tensor m_again = torch::silu(back_to_middle->forward(torch::cat({up(coarsest), m}, 1)).to(torch::kFloat32));
    features = torch::silu(back_to_fine->forward(torch::cat({up(m_again), f}, 1)).to(torch::kFloat32));
  }
  const Tensor proposed = propose->forward(coarsest).view({batch, kPathHypotheses, 2 * kPathSines + 1});
  ProposedPaths out;
  out.log_probability = torch::log_softmax(proposed.select(2, 2 * kPathSines), 1);
  const Tensor falling = 1 / torch::arange(1, kPathSines + 1, map.options());  // finer bends are smaller
  Tensor sines = proposed.narrow(2, 0, 2 * kPathSines).view({batch, kPathHypotheses, 2, kPathSines}) * falling * kUnit;
  out.rounds.push_back(sines);

  const Tensor times = path_times().to(map.device()), basis = sines_at(times);  // (14, 32)
  const Tensor waves = torch::arange(1, kTimes / 2 + 1, map.options()).unsqueeze(1) * M_PI * times;
  const Tensor time = torch::cat({torch::sin(waves), torch::cos(waves)}).t().expand({tokens, kPathPoints, kTimes});
  const Tensor straight = path_places({}, times, length).unsqueeze(1);  // (B, 1, 32, 2)
  const Tensor around = places_around().to(map.device());
  const auto as_tokens = [&](const Tensor& x) { return x.reshape({tokens, kPathPoints, -1}); };
  for (int64_t round = 0; round < kPathRounds; ++round) {
    sines = sines.detach();
    const Tensor offsets = path_offsets(sines, times), places = straight + offsets;  // (B, 4, 32, 2)
    const Tensor looks = (places.unsqueeze(3) + around).flatten(2, 3);               // (B, 4, 32 * 9, 2)
    const Tensor seen = at_places(own, looks).view({batch, kPathHypotheses, kPathPoints, kLooks});
    const Tensor there = at_places(features, places).permute({0, 2, 3, 1});
    const Tensor sees =
        torch::cat({as_tokens(there), as_tokens(seen), as_tokens(offsets / kUnit), as_tokens(places / 4), time,
                    as_tokens(size.expand({batch, kPathHypotheses, kPathPoints, 1}))},
                   2);
    Tensor x;
    {
      const Bfloat16Products products(bfloat16 && is_training());
      x = look->forward(sees).to(torch::kFloat32);
      for (const auto& layer : *mix) x = layer->as<PathMixer>()->forward(x);
    }
    const Tensor moved = move->forward(x).view({batch, kPathHypotheses, kPathPoints, 2}) * kUnit;
    // What of it the sines can tell: they are orthogonal at these times.
    sines = sines + torch::matmul(moved.transpose(2, 3), basis.t()) * (2. / kPathPoints);
    out.rounds.push_back(sines);
  }
  return out;
}

}  // namespace inhabit::inbetween
