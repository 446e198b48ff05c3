// Exact nearest motion word among 100,000 for 10,000 queries: WordIndex against a straightforward double loop (timed on
// 50 of the queries). Words of generated people. Run: ndms_search_benchmark
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <filesystem>

#include "inhabit/data/native.h"
#include "inhabit/metrics/motion_words.h"
#include "inhabit/synth/generate.h"

namespace {

using namespace inhabit;
using torch::Tensor;

struct Words {
  Tensor database, queries;
};

const Words& words() {
  static const Words made = [] {
    const auto folder = std::filesystem::temp_directory_path() / ("inhabit_words_" + std::to_string(::getpid()));
    GenerateOptions options;
    options.clips = 320;
    options.seed = 7;
    generate_rooms(folder.string(), options);
    const Dataset data = open_dataset(folder.string());
    std::vector<Tensor> all;
    for (const DatasetClip& entry : data.clips) all.push_back(pose_words(load_clip(data, entry).joints, 8).flatten(1));
    std::filesystem::remove_all(folder);
    const Tensor joined = torch::cat(all);
    return Words{joined.slice(0, 0, 100000).contiguous(), joined.slice(0, 100000, 110000).contiguous()};
  }();
  return made;
}

void double_loop(benchmark::State& state) {
  constexpr int64_t kQueries = 50;
  const Words& w = words();
  const int64_t count = w.database.size(0), width = w.database.size(1);
  const float* database = w.database.data_ptr<float>();
  const float* queries = w.queries.data_ptr<float>();
  for (auto _ : state) {
    int64_t sum = 0;
    for (int64_t q = 0; q < kQueries; ++q) {
      float best = HUGE_VALF;
      int64_t at = 0;
      for (int64_t n = 0; n < count; ++n) {
        float distance = 0;
        for (int64_t k = 0; k < width; ++k) {
          const float d = database[n * width + k] - queries[q * width + k];
          distance += d * d;
        }
        if (distance < best) {
          best = distance;
          at = n;
        }
      }
      sum += at;
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * kQueries);
}
BENCHMARK(double_loop)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(1);

void word_index(benchmark::State& state) {
  const WordIndex index(words().database);
  for (auto _ : state) benchmark::DoNotOptimize(index.nearest(words().queries).data_ptr<int64_t>());
  state.SetItemsProcessed(state.iterations() * words().queries.size(0));
}
BENCHMARK(word_index)->Unit(benchmark::kMillisecond)->UseRealTime();

void build_word_index(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(WordIndex(words().database).words().size(0));
}
BENCHMARK(build_word_index)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
