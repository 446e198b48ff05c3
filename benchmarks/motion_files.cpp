// Reading motion text, retargeting and resampling: a clip of 4000 frames made in memory, so that nothing is measured
// but the readers.
#include <benchmark/benchmark.h>

#include "inhabit/io/bvh.h"
#include "inhabit/io/expmap_text.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"

namespace {

using namespace inhabit;

constexpr int kFrames = 4000;

// CMU exponential maps of a person who sways: smooth and different in every column.
const std::string& cmu_text() {
  static const std::string text = [] {
    std::string out;
    char number[32];
    for (int t = 0; t < kFrames; ++t)
      for (int k = 0; k < 117; ++k) {
        const double place = k == 1 ? 17 : 0.01 * t;
        const double value = k < 3 ? place : 0.2 * std::sin(0.01 * t * (1 + k % 7) + k);
        std::snprintf(number, sizeof number, "%.9g%c", value, k == 116 ? '\n' : ',');
        out += number;
      }
    return out;
  }();
  return text;
}

const Clip& cmu_clip() {
  static const Clip clip = expmap_motion(parse_expmap_channels(cmu_text(), "swaying"), "swaying").clip;
  return clip;
}

void read_expmap(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(expmap_motion(parse_expmap_channels(cmu_text(), "swaying"), "swaying"));
  state.SetBytesProcessed(state.iterations() * static_cast<int64_t>(cmu_text().size()));
}
BENCHMARK(read_expmap)->Unit(benchmark::kMillisecond);

void read_bvh_file(benchmark::State& state) {
  const std::string path = std::filesystem::temp_directory_path() / "inhabit_motion_files_benchmark.bvh";
  write_bvh(path, cmu_clip());
  for (auto _ : state) benchmark::DoNotOptimize(read_bvh(path));
  state.SetBytesProcessed(state.iterations() * static_cast<int64_t>(std::filesystem::file_size(path)));
  std::filesystem::remove(path);
}
BENCHMARK(read_bvh_file)->Unit(benchmark::kMillisecond);

void retarget_to_standard(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(retarget(cmu_clip(), "swaying"));
  state.SetItemsProcessed(state.iterations() * kFrames);
}
BENCHMARK(retarget_to_standard)->Unit(benchmark::kMillisecond);

void resample_120_to_30(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(resample(cmu_clip(), 30));
  state.SetItemsProcessed(state.iterations() * kFrames);
}
BENCHMARK(resample_120_to_30)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
