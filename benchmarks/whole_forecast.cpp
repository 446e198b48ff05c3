// A whole forecast: an observed second and a furnished room's meshes in, two seconds of joints out. First by the plain
// LibTorch networks, then by the forecaster on the same input; `ratio` is plain time over fast time in this run,
// `error` the largest difference of the contact maps, `joints_mm` that of the joints (untrained weights: a contact
// point may be one of two that are equally near). Last a whole run() with the shipped weights.
#include <benchmark/benchmark.h>

#include <chrono>

#include "inhabit/forecast/contact_forecaster.h"
#include "inhabit/forecast/features.h"
#include "inhabit/forecast/window_frame.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/scene/sampling.h"
#include "inhabit/synth/room.h"
#include "inhabit/thread_variables.h"
#include "room_cloud.h"

namespace {

using namespace inhabit;
using torch::Tensor;

struct Case {
  forecast::Networks networks;
  Scene room;
  Tensor past;
  double plain_seconds = 0;

  explicit Case(const std::string& preset) {
    torch::manual_seed(1);
    const forecast::Config config = forecast::preset(preset);
    networks = {config, forecast::ContactNetwork(config), forecast::MotionNetwork(config),
                forecast::MotionNetwork(nullptr)};
    for (auto& buffer : networks.contact->named_buffers()) {
      if (buffer.value().is_floating_point()) buffer.value().uniform_(0.5, 1.5);  // statistics as if trained
    }
    networks.contact->eval();
    networks.motion->eval();
    for (const auto& module : networks.contact->modules(false)) {
      if (auto* layer = module->as<nn::PointVoxelConvImpl>()) layer->dense = true;
    }
    std::mt19937_64 random(1);
    room = make_room(random).scene();
    past = somebody(config.past, config.joints)[0] + torch::tensor({0.F, 0.95F, 0.F});
  }

  Tensor points() const {
    std::mt19937_64 random(2);
    const forecast::Config& c = networks.config;
    return sample_points_near(room, past[c.past - 1][c.root], c.inference.radius, c.inference.points, random);
  }
};

Case& case_of(const std::string& preset) {
  static Case compact("compact"), paper("paper");
  return preset == "paper" ? paper : compact;
}

/// forecast::ContactForecaster::predict() in LibTorch's own operators.
forecast::Forecast plain_forecast(Case& the, const Tensor& points) {
  torch::NoGradGuard no_gradients;
  const forecast::Config& c = the.networks.config;
  const forecast::WindowFrame frame = forecast::window_frame(the.past, c);
  const Tensor past = frame.to_window(the.past).unsqueeze(0), scene = frame.to_window(points).unsqueeze(0);
  const Tensor dct = the.networks.contact->forward(scene, forecast::contact_features(scene, past, c), past);
  forecast::Forecast out;
  out.contact_dct = dct[0];
  const Tensor contacts = forecast::contact_points(scene, dct, c);
  out.joints = frame.to_world(forecast::forecast_joints(the.networks.motion->forward(past, contacts), c.root)[0]);
  return out;
}

/// Least seconds that `work` takes in this benchmark's iterations.
template <class Work>
double measure(benchmark::State& state, const Work& work) {
  double least = 1e9;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(work());
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

void plain(benchmark::State& state, const std::string& preset) {
  Case& the = case_of(preset);
  the.plain_seconds = measure(state, [&] { return plain_forecast(the, the.points()).joints; });
}

void fast(benchmark::State& state, const std::string& preset) {
  Case& the = case_of(preset);
  const forecast::ContactForecaster forecaster(the.networks);
  const forecast::Forecast expected = plain_forecast(the, the.points()),
                           got = forecaster.predict(the.past, the.points());
  const double error = (got.contact_dct - expected.contact_dct).abs().max().item<double>() /
                       expected.contact_dct.abs().max().item<double>();
  if (!(error < 1e-4)) return state.SkipWithError("fast and plain contact networks differ");
  state.counters["error"] = error;
  state.counters["joints_mm"] = 1000 * (got.joints - expected.joints).abs().max().item<double>();
  const double seconds = measure(state, [&] { return forecaster.predict(the.past, the.points()).joints; });
  if (the.plain_seconds > 0) state.counters["ratio"] = the.plain_seconds / seconds;
}

/// The bundled walk in its room and the shipped model, clip in and clip out: retargeting, networks, the solver, back
/// onto the file's skeleton; then without the solver, and what a stream asks for.
void run(benchmark::State& state, bool refine, bool joints_alone) {
  const std::string source = INHABIT_SOURCE_DIR;
  const auto forecaster = forecast::ContactForecaster::load(source + "/models/forecast-compact.safetensors");
  const Clip walk = read_clip(source + "/examples/data/walk.npz");
  const Scene room = read_scene_file(source + "/examples/data/walk_room.glb").scene;
  forecast::Options options;
  options.start = 60;
  options.refine = refine;
  options.joints_alone = joints_alone;
  for (auto _ : state) benchmark::DoNotOptimize(forecaster.run(walk, room, options).prediction.joints);
}

BENCHMARK_CAPTURE(plain, compact, "compact")->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(5);
BENCHMARK_CAPTURE(fast, compact, "compact")->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(30);
BENCHMARK_CAPTURE(plain, paper, "paper")->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(5);
BENCHMARK_CAPTURE(fast, paper, "paper")->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(30);
BENCHMARK_CAPTURE(run, refined, true, false)->Unit(benchmark::kMillisecond)->UseRealTime()->MinWarmUpTime(0.5);
BENCHMARK_CAPTURE(run, raw, false, false)->Unit(benchmark::kMillisecond)->UseRealTime()->MinWarmUpTime(0.5);
BENCHMARK_CAPTURE(run, joints_alone, false, true)->Unit(benchmark::kMillisecond)->UseRealTime()->MinWarmUpTime(0.5);

}  // namespace

int main(int argc, char** argv) {
  inhabit::start_with_thread_variables(argv);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
