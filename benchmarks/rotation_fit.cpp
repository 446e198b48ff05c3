// Rotations from joint positions: in closed form against the solver over all frames, on recordings, whose rotations are
// known, and on the joints of futures, whose bones wobble. Counters: distance of the posed joints from their targets,
// angle of rotations to the true ones, and flips, joints that rotate by more than a radian from one frame to the next.
#include <benchmark/benchmark.h>

#include "inhabit/anticipate/fast_futures.h"
#include "inhabit/anticipate/features.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/body/fit.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/io/files.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/local_pose.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/thread_variables.h"

namespace {

using namespace inhabit;
using torch::Tensor;

struct Input {
  BodyModel body = builtin_body();
  Tensor joints, rotations;  // rotations where they are known

  void stand_on(const Skeleton& skeleton) {
    body.skeleton = skeleton;
    body.joint_template = skeleton.rest_joints();
    body.joint_dirs = torch::zeros_like(body.joint_dirs);
  }
};

Clip recording(const std::string& path) { return resample(retarget(read_clip(path), path), 25, path); }

Input recorded(const std::string& path) {
  const Clip clip = recording(path);
  Input in;
  in.stand_on(clip.skeleton);
  in.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  in.rotations = clip.rotations;
  return in;
}

/// The joints of four futures of the shipped model one after the other, as its network gives them.
Input anticipated() {
  using namespace inhabit::anticipate;
  const Networks networks = load_networks(INHABIT_SOURCE_DIR "/models/anticipate-cmu.safetensors");
  const Clip past = on_skeleton(recording(INHABIT_SOURCE_DIR "/examples/data/walk.npz"), networks.skeleton);
  constexpr int64_t kSamples = 4, kFrames = 750;
  const Tensor seen = past.joints,
               features = observation(joint_features(seen), seen.size(0), networks.config.observed).unsqueeze(0);
  const Futures futures =
      FastFutures(networks).forward(features, draw_noise(networks.config, kSamples, kFrames, 1), kFrames);
  const Tensor last = seen[seen.size(0) - 1];
  Input in;
  in.stand_on(networks.skeleton);
  in.joints = feature_joints(futures.features, last[0].expand({kSamples, 3}), headings(last).expand({kSamples}));
  return in;
}

/// Largest angle, radians, of rotation matrices (..., 3, 3).
Tensor angles(const Tensor& matrices) { return matrix_to_axis_angle(matrices).norm(2, -1); }

void fit(benchmark::State& state, const Input& in, bool closed) {
  const torch::NoGradGuard no_gradients;
  const Tensor clips = in.joints.dim() == 3 ? in.joints.unsqueeze(0) : in.joints;
  double mean = 0, most = 0, flips = 0, fastest = 0, turned = 0;
  for (int64_t s = 0; s < clips.size(0); ++s) {
    const BodyFit got = closed ? fit_rotations(in.body, clips[s]) : fit_body(in.body, clips[s]);
    mean += 1000 * got.mean_error / static_cast<double>(clips.size(0));
    most = std::max(most, 1000 * got.max_error);
    const Tensor r = axis_angle_to_matrix(got.rotations);
    const Tensor between = angles(r.slice(0, 0, -1).transpose(-1, -2).matmul(r.slice(0, 1)));
    flips += (between > 1).sum().item<double>();
    fastest = std::max(fastest, between.max().item<double>() * 180 / M_PI);
    if (!in.rotations.defined()) continue;
    const std::vector<int>& parents = in.body.skeleton.parents;
    const auto global = [&](const Tensor& local) {
      return forward_kinematics(parents, in.body.skeleton.offsets, axis_angle_to_matrix(local), got.trans).rotations;
    };
    const Tensor off = angles(global(in.rotations).transpose(-1, -2).matmul(global(got.rotations)));
    const Tensor moving = torch::tensor({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 13, 14, 16, 17, 18, 19});
    turned += off.index_select(1, moving).mean().item<double>() * 180 / M_PI;
    if (std::getenv("INHABIT_FIT_JOINTS") != nullptr) std::cerr << off.mean(0) * 180 / M_PI << "\n";
  }
  state.counters["mean_mm"] = mean;
  state.counters["max_mm"] = most;
  state.counters["flips"] = flips;
  state.counters["fastest_deg"] = fastest;
  state.counters["off_deg"] = turned;
  for (auto _ : state)
    for (int64_t s = 0; s < clips.size(0); ++s)
      benchmark::DoNotOptimize(closed ? fit_rotations(in.body, clips[s]) : fit_body(in.body, clips[s]));
  state.SetItemsProcessed(state.iterations() * clips.size(0) * clips.size(1));
}

}  // namespace

int main(int argc, char** argv) {
  start_with_thread_variables(argv);
  std::vector<std::pair<std::string, Input>> inputs;
  inputs.emplace_back("walk", recorded(INHABIT_SOURCE_DIR "/examples/data/walk.npz"));
  inputs.emplace_back("sit", recorded(INHABIT_SOURCE_DIR "/examples/data/sit.npz"));
  inputs.emplace_back("futures", anticipated());
  for (int i = 1; i < argc; ++i)  // other recordings
    if (argv[i][0] != '-') inputs.emplace_back(argv[i], recorded(argv[i]));
  for (const auto& [name, input] : inputs)
    for (const bool closed : {false, true})
      benchmark::RegisterBenchmark((name + (closed ? "/closed_form" : "/solver")).c_str(),
                                   [&input = input, closed](benchmark::State& s) { fit(s, input, closed); })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
