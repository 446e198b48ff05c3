#pragma once
#include <vector>

#include "inhabit/interact/fast_control_network.h"
#include "inhabit/interact/fast_pose_network.h"
#include "inhabit/interact/layout.h"
#include "inhabit/interact/model_file.h"
#include "inhabit/interact/voxels.h"

namespace inhabit::interact {

/// A model as it runs: networks and layouts, shared by any number of people. Safe to use from several threads.
class Engine {
 public:
  /// Throws Error where PoseNet or ControlNet is missing.
  explicit Engine(const Networks& networks);

  const Config& config() const { return networks_.config; }
  const Networks& networks() const { return networks_; }
  const InputLayout& input() const { return input_; }
  const OutputLayout& output() const { return output_; }
  const EgoGrid& ego() const { return ego_; }

  /// What one person's frames are computed in, and what ControlNet carries from frame to frame.
  struct Workspace {
    explicit Workspace(const Engine& engine);
    std::vector<float> input, output;  ///< of PoseNet (InputLayout::size, OutputLayout::size)
    std::vector<float> memory;         ///< of ControlNet's LSTM
    FastPoseNetwork::Workspace pose;
    FastControlNetwork::Workspace control;
  };

  /// PoseNet: features as they are in work.input, which is overwritten, to work.output.
  void pose(Workspace& work) const;

  /// ControlNet begins a reach anew.
  void start_control(Workspace& work) const { control_.start(work.memory.data()); }
  /// One frame of it on features as they are (features.h): pose (66), control (56) to out (56).
  void control(const float* pose, const float* control, float* out, Workspace& work) const {
    control_.step(pose, control, 1, work.memory.data(), out, work.control);
  }

 private:
  Networks networks_;
  InputLayout input_;
  OutputLayout output_;
  EgoGrid ego_;
  FastPoseNetwork pose_;
  FastControlNetwork control_;
  std::vector<float> input_mean_, input_factor_, output_mean_, output_factor_;
};

}  // namespace inhabit::interact
