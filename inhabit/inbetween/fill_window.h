#pragma once
#include <torch/types.h>

#include <vector>

#include "inhabit/inbetween/fast_denoiser.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/inbetween/scene_probe.h"
#include "inhabit/inbetween/schedule.h"
#include "inhabit/inbetween/windows.h"
#include "inhabit/refine/refine_generated.h"
#include "inhabit/scene/query.h"

namespace inhabit::inbetween {

/// What is constrained of a clip, frame by frame.
struct FrameConstraints {
  torch::Tensor groups;                       ///< (T, 25) what each frame constrains (keyframes.h)
  std::vector<refine::JointTarget> contacts;  ///< joints that controls put somewhere
  torch::Tensor path;                         ///< (T, 3) of path_curve; undefined: none
};

/// A clip on the standard skeleton that is being filled, window by window.
struct Filling {
  const Networks& networks;
  const DiffusionSchedule& schedule;
  FastDenoiser& denoiser;
  const SceneQuery& query;
  const Options& options;
  const std::vector<int64_t>& keys;
  bool noisy = false;  ///< keys between the ends are cleaned
  double noise = 0;    ///< level of noise on them, of models that are told it
  int64_t steps = 1;
  double temperature = 0;           ///< of Options
  torch::Tensor body_shape;         ///< (1, 7)
  double floor = 0;                 ///< metres, height
  const SceneDistances& distances;  ///< of a model of residual motion: the floor at height 0
  FrameConstraints constraints;     ///< of the whole clip
  Clip motion;                      ///< key poses, and what is filled so far
  std::vector<int64_t> unreached;   ///< keys that no path around obstacles leads to
  torch::Tensor feet = {};          ///< (T, 4) of SampledMotion

  const Config& config() const { return networks.config; }
  int64_t last_frame() const { return motion.frames() - 1; }
};

/// Samples window number `w` of `windows` and puts it into the clip.
void fill_window(Filling& filling, const std::vector<FillWindow>& windows, size_t w);

}  // namespace inhabit::inbetween
