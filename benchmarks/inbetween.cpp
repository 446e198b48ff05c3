// In-betweening: one guided step of the denoiser the plain way (two evaluations, the scene's and the body's embeddings
// in each), with tensor operators and the pair in one batch, and fast; the scene's embedding by itself; whole clips
// of 121 frames at the default steps; and all that fills one in a room.
#include "inhabit/inbetween/fast_denoiser.h"

#include <ATen/Parallel.h>
#include <benchmark/benchmark.h>

#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/residual_input.h"
#include "inhabit/inbetween/sampler.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/thread_variables.h"

namespace {

using namespace inhabit;
using torch::Tensor;

const char* const kPresets[] = {"paper", "features"};  // "compact", of residual motion, is 2 where it is measured

/// A clip with keys every 60 frames in a random scene, weights of no training.
struct Input {
  inbetween::Denoiser network{nullptr};
  Tensor x, mask, occupancy, offsets, keys, shape;

  explicit Input(const benchmark::State& state) {
    const inbetween::Config config = inbetween::preset(kPresets[state.range(0)]);
    at::set_num_threads(static_cast<int>(state.range(1)));
    torch::manual_seed(1);
    network = inbetween::Denoiser(config);
    const torch::NoGradGuard no_gradients;
    for (Tensor& p : network->parameters()) p.add_(torch::randn_like(p), 0.02);  // none of them zero
    network->eval();
    x = torch::randn({1, inbetween::kFeatureCount, config.frames});
    keys = torch::zeros({1, config.frames});
    for (const int64_t key : {0, 60, 120}) keys.select(1, key).fill_(1);
    mask = keys.unsqueeze(1).expand({1, config.mask_channels(), config.frames});
    const int64_t side = config.scene_encoder.side;
    occupancy = torch::where(torch::rand({1, side / 2, side, side}) < 0.2, 1.F, -1.F);
    offsets = torch::randn({1, config.anchors, 3, config.frames});
    shape = torch::rand({1, inbetween::kShapeFeatures});
  }
  double guidance() const { return network->config.inference.guidance; }
  Tensor local() {
    const Tensor seen = network->embed_offsets(offsets, keys);
    return network->config.from_interpolation ? torch::cat({seen, x}, 1) : seen;
  }

  /// Everything anew in each of the two evaluations.
  Tensor plain(int64_t t) {
    const Tensor step = torch::full({1}, t, torch::kInt64);
    const auto evaluated = [&](bool with_scene) {
      const Tensor scene = network->embed_scene(occupancy);
      return network->forward(x, mask, local(), step, (with_scene ? scene : 0 * scene) + network->embed_shape(shape));
    };
    const Tensor with = evaluated(true), without = evaluated(false);
    return without + guidance() * (with - without);
  }
};

double difference(const Tensor& got, const Tensor& expected) {
  return ((got - expected).abs().max() / expected.abs().max()).item<double>();
}

void plain(benchmark::State& state) {
  const torch::NoGradGuard no_gradients;
  Input in(state);
  for (auto _ : state) benchmark::DoNotOptimize(in.plain(500));
}

void batched(benchmark::State& state) {
  const torch::NoGradGuard no_gradients;
  Input in(state);
  const Tensor shape = in.network->embed_shape(in.shape), scene = in.network->embed_scene(in.occupancy);
  const Tensor x = in.x.repeat({2, 1, 1}), mask = in.mask.repeat({2, 1, 1}), local = in.local().repeat({2, 1, 1});
  const Tensor embedding = torch::cat({scene + shape, shape}), step = torch::full({2}, 500, torch::kInt64);
  for (auto _ : state) {
    const std::vector<Tensor> both = in.network->forward(x, mask, local, step, embedding).chunk(2);
    benchmark::DoNotOptimize(both[1] + in.guidance() * (both[0] - both[1]));
  }
}

void fast(benchmark::State& state) {
  const torch::NoGradGuard no_gradients;
  Input in(state);
  const Tensor shape = in.network->embed_shape(in.shape), scene = in.network->embed_scene(in.occupancy),
               local = in.local();
  inbetween::FastDenoiser denoiser(in.network);
  const auto step = [&] { return denoiser.guided(in.x, in.mask, local, 500, scene, shape, in.guidance()); };
  const double error = difference(step(), in.plain(500));
  if (!(error < 1e-4)) return state.SkipWithError("fast and plain outputs differ");
  state.counters["error"] = error;
  for (auto _ : state) benchmark::DoNotOptimize(step());
}

void scene(benchmark::State& state) {
  const torch::NoGradGuard no_gradients;
  Input in(state);
  for (auto _ : state) benchmark::DoNotOptimize(in.network->embed_scene(in.occupancy));
}

/// Embeddings, packing of the weights and all steps of a clip.
void clip(benchmark::State& state) {
  const torch::NoGradGuard no_gradients;
  Input in(state);
  const inbetween::Config& config = in.network->config;
  const inbetween::DiffusionSchedule schedule = inbetween::cosine_schedule(config.diffusion_steps);
  const inbetween::KeyConstraints given{in.x, in.keys.unsqueeze(1).expand_as(in.x), config.t_star};
  for (auto _ : state) {
    inbetween::FastDenoiser denoiser(in.network);
    const Tensor local = in.local(), around = in.network->embed_scene(in.occupancy),
                 shape = in.network->embed_shape(in.shape);
    benchmark::DoNotOptimize(sample(
        schedule, inbetween::Sampler::dpm_solver, inbetween::Config::Inference().steps,
        [&](const Tensor& x, int64_t t) {
          return denoiser.guided(x, in.mask, local, t, around, shape, config.inference.guidance);
        },
        given, inbetween::seeded_noise(1, inbetween::kFeatureCount, config.frames, 1)));
  }
  state.counters["steps"] = static_cast<double>(inbetween::Config::Inference().steps);
}

/// Residual motion at the compact size, weights of no training.
inbetween::Networks residual_networks() {
  inbetween::Networks out;
  out.config = inbetween::preset("compact");
  torch::manual_seed(1);
  out.network = inbetween::Denoiser(out.config);
  const torch::NoGradGuard no_gradients;
  for (Tensor& p : out.network->parameters()) p.add_(torch::randn_like(p), 0.02);
  out.network->eval();
  out.residual_table = torch::full({inbetween::kScaleRows, inbetween::kResidualFeatures}, 0.05);
  out.residual_table[0].zero_();
  return out;
}

/// One step of residual motion by tensor operators, and fast.
void residual_step(benchmark::State& state) {
  const torch::NoGradGuard no_gradients;
  at::set_num_threads(static_cast<int>(state.range(1)));
  inbetween::Denoiser network = residual_networks().network;
  const Tensor input = torch::randn({1, inbetween::kResidualChannels, network->config.frames}),
               step = torch::full({1}, 500, torch::kInt64),
               shape = network->embed_shape(torch::rand({1, inbetween::kBoneFeatures}));
  inbetween::FastDenoiser denoiser(network);
  if (!(difference(denoiser.residual(input, 500, shape), network->residual(input, step, shape)) < 1e-4))
    return state.SkipWithError("fast and plain outputs differ");
  if (state.range(0) == 0) {
    for (auto _ : state) benchmark::DoNotOptimize(network->residual(input, step, shape));
  } else {
    for (auto _ : state) benchmark::DoNotOptimize(denoiser.residual(input, 500, shape));
  }
}

/// Everything that a user's call does with such a clip: the room, the sampler and what makes feet stand and keys be
/// met.
void fill(benchmark::State& state) {
  inbetween::Networks networks;
  if (state.range(0) == 2) {
    at::set_num_threads(static_cast<int>(state.range(1)));
    networks = residual_networks();
  } else {
    const Input in(state);
    networks.config = in.network->config;
    networks.network = in.network;
    networks.scale = {torch::zeros({inbetween::kFeatureCount}), torch::ones({inbetween::kFeatureCount})};
  }
  const inbetween::SceneInbetweener inbetweener(networks);
  const std::string data = std::string(INHABIT_SOURCE_DIR) + "/examples/data/";
  const Clip clip = slice(read_clip(data + "sit.npz"), 0, networks.config.frames);
  const Scene room = read_scene_file(data + "sit_room.glb", {}).scene;
  inbetween::Options options;
  options.keys = inbetween::key_frames("every:60", clip.frames());
  options.standard = true;
  for (auto _ : state) benchmark::DoNotOptimize(inbetweener.run(clip, room, options));
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"preset", "threads"})->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
  for (const int64_t preset : {0, 1})
    for (const int64_t threads : {1, 2}) b->Args({preset, threads});
}
BENCHMARK(plain)->Name("inbetween/step_plain")->Apply(sizes);
BENCHMARK(batched)->Name("inbetween/step_batched")->Apply(sizes);
BENCHMARK(fast)->Name("inbetween/step_fast")->Apply(sizes);
BENCHMARK(scene)->Name("inbetween/scene")->Apply(sizes);
BENCHMARK(clip)->Name("inbetween/clip")->Apply(sizes);
BENCHMARK(residual_step)
    ->Name("inbetween/residual_step")
    ->ArgNames({"fast", "threads"})
    ->Args({0, 1})
    ->Args({1, 1})
    ->Args({0, 2})
    ->Args({1, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK(fill)->Name("inbetween/fill")->Apply(sizes)->Args({2, 1})->Args({2, 2});

}  // namespace

int main(int argc, char** argv) {
  start_with_thread_variables(argv);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
