#include "inhabit/inbetween/train_path.h"

#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/math/random.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr double kLater = 0.7;      // a round counts so much of the next
constexpr double kOthers = 0.03;    // of the paths that are not nearest: none is left behind
constexpr double kClearWeight = 2;  // of clearance, metres against metres of distance
constexpr double kWellClear = 0.45,
                 kOthersClear = 0.3;    // metres that the nearest path, and others, keep from obstacles
constexpr double kLikelyWeight = 0.03;  // of the log-probabilities
constexpr int64_t kClearPoints = 96;    // of a path whose clearance counts: it must not jump over what is thin
constexpr int64_t kEpoch = 100'000, kFloorBatches = 8, kBatchFloors = 64;

}  // namespace

Losses path_losses(PathNet network, const DrawnFloors& floors) {
  const ProposedPaths proposed = network->forward(path_map(floors.distance), floors.length);
  const Tensor times = path_times().to(floors.length.device()), target = floors.offsets.unsqueeze(1),
               map = floors.distance.unsqueeze(1);
  const Tensor often = (torch::arange(kClearPoints, times.options()) + 0.5) / static_cast<double>(kClearPoints);
  const auto straight = [&](const Tensor& at) { return path_places({}, at, floors.length).unsqueeze(1); };
  const auto clearance = [&](const Tensor& places) { return at_places(map, places).squeeze(1); };
  const Tensor line = straight(often);
  // A*'s own clearance, as often: (B, 1, 96), each of its 32 points three times.
  const Tensor should = clearance(straight(times) + target).repeat_interleave(kClearPoints / kPathPoints, 2);
  const Tensor ends = torch::minimum(often, 1 - often) * floors.length.unsqueeze(1);
  const Tensor inner = (ends > kNearKeys).to(torch::kFloat32).unsqueeze(1);
  const auto distances = [&](const Tensor& sines) {  // (B, 4)
    return ((path_offsets(sines, times) - target).square().sum(3) + 1e-4).sqrt().mean(2);
  };
  const Tensor nearest = distances(proposed.rounds.back()).argmin(1, true);  // (B, 1)
  const Tensor of_nearest = nearest.unsqueeze(2).expand({-1, 1, kClearPoints});
  Tensor total = torch::zeros({}, times.options());
  double weight = 1;
  for (auto sines = proposed.rounds.rbegin(); sines != proposed.rounds.rend(); ++sines, weight *= kLater) {
    const Tensor away = distances(*sines);
    const Tensor distance = (1 - kOthers) * away.gather(1, nearest).mean() + kOthers * away.mean();
    const Tensor keeps = clearance(line + path_offsets(*sines, often));  // (B, 4, 96)
    const Tensor short_of = (kOthersClear - keeps).clamp_min(0) * inner;
    const Tensor clear =
        short_of.mean() + (should.clamp_max(kWellClear) - keeps.gather(1, of_nearest)).clamp_min(0).mean();
    total = total + weight * (distance + kClearWeight * clear);
  }
  const Tensor likely = -proposed.log_probability.gather(1, nearest).mean();
  total = total + kLikelyWeight * likely;
  const torch::NoGradGuard no_gradients;
  const Tensor first = proposed.log_probability.argmax(1, true), last = proposed.rounds.back();
  const Tensor taken = first.unsqueeze(2).expand({-1, 1, kClearPoints});
  const Tensor keeps = clearance(line + path_offsets(last, often)).gather(1, taken);
  const Tensor touches = ((keeps < kWide) & (should >= kWide)).to(torch::kFloat32).mean();
  return {
      {"total", total}, {"likely", likely}, {"metres", distances(last).gather(1, first).mean()}, {"touches", touches}};
}

TrainTask path_task(const PathNet& network, uint64_t seed, torch::Device device) {
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{"path.", network.ptr()}};
  task.samples = kEpoch;
  task.prepare = batches([](const TrainStep& step) { return draw_floors(step.indices.size(), step.seed); },
                         [network, device](const DrawnFloors& floors, const TrainStep&) {
                           return path_losses(network, floors.to(device));
                         });
  task.validate = [network, seed, device] {
    double sum = 0;
    for (int64_t i = 0; i < kFloorBatches; ++i)
      sum += path_losses(network, draw_floors(kBatchFloors, item_seed(~seed, static_cast<uint64_t>(i))).to(device))
                 .front()
                 .second.item<double>();
    return sum / kFloorBatches;
  };
  return task;
}

}  // namespace inhabit::inbetween
