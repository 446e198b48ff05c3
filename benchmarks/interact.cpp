// A frame of chair interaction: PoseNet and ControlNet in LibTorch's operators, then the fast evaluations on the same
// rows, for one person and for a hundred at once. Equality is asserted; `error` is relative to the largest output,
// `ratio` LibTorch's time over the fast one's in this run, `fps` how often a second all of them are moved on. LibTorch
// blends the experts' weights for one person, as the release does; for a hundred it blends their outputs, which needs
// less memory. OMP_NUM_THREADS says how many threads there are.
#include <benchmark/benchmark.h>

#include <chrono>
#include <map>

#include "inhabit/interact/fast_control_network.h"
#include "inhabit/interact/fast_pose_network.h"
#include "inhabit/passive_waiting.h"

namespace {

using namespace inhabit;
using interact::PoseNetwork;
using torch::Tensor;

struct Case {
  interact::Config config;
  PoseNetwork pose{nullptr};
  interact::ControlNetwork control{nullptr};
  std::map<std::string, double> seconds;  ///< of LibTorch, by network and number of people

  explicit Case(const std::string& preset)
      : config(interact::preset(preset)), pose(interact::pose_sizes(config)), control(config) {
    torch::manual_seed(1);
    pose->eval();
    control->eval();
  }
};

Case& case_of(const std::string& preset) {
  static Case compact("compact"), paper("paper");
  return preset == "paper" ? paper : compact;
}

Tensor rows_for(const Case& the, int64_t people) {
  torch::manual_seed(2);
  return torch::randn({people, the.pose->sizes.row});
}

/// One person's frame with blended weights.
Tensor with_blended_weights(PoseNetwork& network, const Tensor& x) {
  std::vector<Tensor> codes;
  int64_t first = 0;
  for (size_t i = 0; i < network->encoders.size(); ++i) {
    const int64_t width = network->sizes.inputs[i];
    codes.push_back(network->encoders[i]->forward(x.narrow(1, first, width)));
    first += width;
  }
  const Tensor gates = network->gates(x)[0];
  Tensor h = torch::cat(codes, 1)[0];
  const auto& experts = *network->experts;
  for (size_t layer = 0; layer < experts.weights.size(); ++layer) {
    h = torch::tensordot(gates, experts.weights[layer], {0}, {0}).mv(h) + gates.matmul(experts.biases[layer]);
    if (layer + 1 < experts.weights.size()) h = torch::elu(h);
  }
  return h.unsqueeze(0);
}

Tensor plain_pose(Case& the, const Tensor& x) {
  return x.size(0) == 1 ? with_blended_weights(the.pose, x) : the.pose->forward(x);
}

/// Least seconds that `work` takes in this benchmark's iterations.
template <class Work>
double measure(benchmark::State& state, const Work& work) {
  double least = 1e9;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    work();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  state.counters["fps"] = 1 / least;
  return least;
}

void pose_plain(benchmark::State& state, const std::string& preset, int64_t people) {
  const torch::NoGradGuard no_gradients;
  Case& the = case_of(preset);
  const Tensor x = rows_for(the, people);
  the.seconds["pose" + std::to_string(people)] = measure(state, [&] { benchmark::DoNotOptimize(plain_pose(the, x)); });
}

void pose_fast(benchmark::State& state, const std::string& preset, int64_t people) {
  const torch::NoGradGuard no_gradients;
  Case& the = case_of(preset);
  const interact::FastPoseNetwork fast(the.pose);
  interact::FastPoseNetwork::Workspace workspace;
  const Tensor x = rows_for(the, people), expected = plain_pose(the, x);
  Tensor y = torch::empty_like(expected);
  const auto frame = [&] { fast.forward(x.data_ptr<float>(), people, y.data_ptr<float>(), workspace); };
  frame();
  const double error = ((y - expected).abs().max() / expected.abs().max()).item<double>();
  if (!(error < 1e-4)) return state.SkipWithError("fast and plain outputs differ");
  state.counters["error"] = error;
  const double least = measure(state, frame), plain = the.seconds["pose" + std::to_string(people)];
  if (plain > 0) state.counters["ratio"] = plain / least;
}

void control_plain(benchmark::State& state, const std::string& preset, int64_t people) {
  const torch::NoGradGuard no_gradients;
  Case& the = case_of(preset);
  const Tensor pose = torch::randn({people, the.config.pose_size()}),
               control = torch::randn({people, the.config.control_size()});
  interact::ControlState carried = the.control->start(people);
  the.seconds["control" + std::to_string(people)] =
      measure(state, [&] { benchmark::DoNotOptimize(the.control->step(pose, control, carried)); });
}

void control_fast(benchmark::State& state, const std::string& preset, int64_t people) {
  const torch::NoGradGuard no_gradients;
  Case& the = case_of(preset);
  const interact::FastControlNetwork fast(the.control);
  interact::FastControlNetwork::Workspace workspace;
  const Tensor pose = torch::randn({people, fast.pose_size()}), control = torch::randn({people, fast.control_size()});
  Tensor carried = torch::empty({people, fast.state_size()}), out = torch::empty_like(control);
  for (int64_t i = 0; i < people; ++i) fast.start(carried[i].data_ptr<float>());
  interact::ControlState plain_carried = the.control->start(people);
  const auto frame = [&] {
    fast.step(pose.data_ptr<float>(), control.data_ptr<float>(), people, carried.data_ptr<float>(),
              out.data_ptr<float>(), workspace);
  };
  double error = 0;
  for (int t = 0; t < 30; ++t) {
    frame();
    const Tensor expected = the.control->step(pose, control, plain_carried);
    error = std::max(error, ((out - expected).abs().max() / expected.abs().max()).item<double>());
  }
  if (!(error < 1e-4)) return state.SkipWithError("fast and plain outputs differ");
  state.counters["error"] = error;
  const double least = measure(state, frame), plain = the.seconds["control" + std::to_string(people)];
  if (plain > 0) state.counters["ratio"] = plain / least;
}

}  // namespace

int main(int argc, char** argv) {
  use_passive_waiting(argv);
  for (const std::string preset : {"paper", "compact"})
    for (const int64_t people : {1, 100})
      for (const auto& [name, run] : {std::pair("pose/plain", &pose_plain),
                                      {"pose/fast", &pose_fast},
                                      {"control/plain", &control_plain},
                                      {"control/fast", &control_fast}}) {
        const std::string full = "interact/" + preset + "/" + std::to_string(people) + "/" + name;
        benchmark::RegisterBenchmark(full.c_str(),
                                     [run, preset, people](benchmark::State& state) { run(state, preset, people); })
            ->Unit(benchmark::kMicrosecond)
            ->UseRealTime()
            ->MinTime(0.5);
      }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
