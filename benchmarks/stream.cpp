// Streams with the models that ship, in the bundled room: ten people (`people`) whose poses come at 10 Hz each, or as
// asked. `latency` is the milliseconds from the last pose of a moment until all results that are due are there (median;
// `latency_99` 99 %), `load` the fraction of real time that the stream took: under 1, it keeps up. Poses are given one
// after the other as fast as they are taken, each at its own time. `grown_kB` is what the heap grew by in the second
// half. forecast/POINTS are the network's forecasts with so many scene points (1500: as the model was trained).
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>

#include "inhabit/anticipate/anticipate_stream.h"
#include "inhabit/forecast/forecast_stream.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/thread_variables.h"

namespace {

using namespace inhabit;
using Clock = std::chrono::steady_clock;

constexpr double kInputRate = 10;  // poses a second of each person

const Clip& walk() {
  static const Clip clip = read_clip(INHABIT_SOURCE_DIR "/examples/data/walk.npz");
  return clip;
}

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

size_t heap_bytes() { return mallinfo2().uordblks + mallinfo2().hblkhd; }

/// `people` walk back and forth along the recording for some seconds.
template <class Stream>
void play(benchmark::State& state, Stream& stream, int64_t people, double warm_up, double seconds) {
  std::vector<double> latencies;
  double busy = 0;
  size_t before = 0;
  const auto all = static_cast<int64_t>((warm_up + seconds) * kInputRate),
             first = static_cast<int64_t>(warm_up * kInputRate);
  for (auto _ : state) {
    for (int64_t i = 0; i < all; ++i) {
      if (i == (first + all) / 2) before = heap_bytes();
      const auto start = Clock::now();
      for (int64_t p = 0; p < people; ++p) {
        const int64_t at = (3 * i + 7 * p) % 178, frame = at < 90 ? at : 178 - at;
        stream.push(std::to_string(p), static_cast<double>(i) / kInputRate, walk().joints[frame]);
      }
      const auto pushed = Clock::now();
      const auto results = stream.take();
      for (const auto& r : results)
        if (!r.error.empty()) return state.SkipWithError(r.error.c_str());
      if (i < first) continue;
      busy += seconds_since(start);
      if (!results.empty()) latencies.push_back(1000 * seconds_since(pushed));
    }
  }
  std::sort(latencies.begin(), latencies.end());
  state.counters["people"] = static_cast<double>(people);
  state.counters["latency"] = latencies[latencies.size() / 2];
  state.counters["latency_99"] = latencies[latencies.size() * 99 / 100];
  state.counters["load"] = busy / seconds;
  state.counters["grown_kB"] = (static_cast<double>(heap_bytes()) - static_cast<double>(before)) / 1e3;
}

/// @param people, results a second of each, scene points
void forecasts(benchmark::State& state) {
  static const auto forecaster = std::make_shared<const forecast::ContactForecaster>(
      forecast::ContactForecaster::load(INHABIT_SOURCE_DIR "/models/forecast-compact.safetensors"));
  static const Scene room = read_scene_file(INHABIT_SOURCE_DIR "/examples/data/walk_room.glb").scene;
  forecast::StreamOptions options;
  options.poses.rate = static_cast<double>(state.range(1));
  options.forecast.points = state.range(2);
  forecast::ForecastStream stream(forecaster, room, options);
  play(state, stream, state.range(0), 2, 10);
}

/// @param people, results a second of each, futures of 2 s
void futures(benchmark::State& state) {
  static const auto anticipator = std::make_shared<const anticipate::IntentionAnticipator>(
      anticipate::IntentionAnticipator::load(INHABIT_SOURCE_DIR "/models/anticipate-cmu.safetensors"));
  anticipate::StreamOptions options;
  options.poses.rate = static_cast<double>(state.range(1));
  options.anticipate.samples = state.range(2);
  anticipate::AnticipateStream stream(anticipator, options);
  play(state, stream, state.range(0), 2, 10);
}

/// What the stream itself costs, without a network: a window of 30 frames for each pose.
void windows(benchmark::State& state) {
  PoseStream stream({.rate = kInputRate}, 29.0 / 30, 29.0 / 30);
  int64_t i = 0;
  for (auto _ : state) {
    stream.push("a", static_cast<double>(i) / kInputRate, walk().joints[i % 90]);
    ++i;
    for (const PoseStream::Due& due : stream.take()) benchmark::DoNotOptimize(due.window->clip(30, 30));
  }
}

BENCHMARK(forecasts)
    ->Args({1, 10, 1500})
    ->Args({10, 10, 1500})
    ->Args({10, 10, 500})
    ->Args({10, 10, 250})
    ->Args({10, 3, 1500})
    ->Iterations(1)
    ->Unit(benchmark::kSecond)
    ->UseRealTime();
BENCHMARK(futures)
    ->Args({1, 10, 5})
    ->Args({10, 10, 5})
    ->Args({10, 2, 5})
    ->Iterations(1)
    ->Unit(benchmark::kSecond)
    ->UseRealTime();
BENCHMARK(windows)->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) {
  inhabit::start_with_thread_variables(argv);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
