#pragma once
#include <vector>

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

  /// PoseNet on features as they are: in (InputLayout::size), out (OutputLayout::size).
  void pose(float* in, float* out) const;

  /// One frame of ControlNet on features as they are (features.h). @param state of the LSTM, moved on; empty: its
  /// learnt start.
  void control(const float* pose, const float* control, ControlState& state, float* out) const;

 private:
  Networks networks_;
  InputLayout input_;
  OutputLayout output_;
  EgoGrid ego_;
};

}  // namespace inhabit::interact
