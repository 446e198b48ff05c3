#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/interact/control_network.h"
#include "inhabit/interact/expert_kernel.h"
#include "inhabit/interact/work_stages.h"

namespace inhabit::interact {

/// Inference-only evaluation of ControlNet on the CPU, frame by frame: the same outputs as ControlNetworkImpl::step()
/// to 1e-4 (weights in 16 bits where these do, expert_kernel.h), without a graph and without allocating. Copies share
/// the weights.
class FastControlNetwork {
 public:
  explicit FastControlNetwork(const ControlNetwork& network);

  /// What step() works in: of one thread at a time. It grows with the first call of so many rows.
  struct Workspace {
    std::vector<float> encoders;             ///< hidden layers of both
    std::vector<std::vector<float>> inputs;  ///< of each LSTM layer: what is below, then its own hidden state; at the
                                             ///< end what the output layer sees
    WorkStages stages;
  };

  int64_t pose_size() const { return pose_; }
  int64_t control_size() const { return control_; }
  /// Floats that a person's state takes: hidden, then cell, layer by layer.
  int64_t state_size() const { return 2 * layers() * width_; }
  /// The learnt state that a motion starts with.
  void start(float* state) const;

  /// One frame for `rows` people. @param pose (rows, pose_size()); @param control (rows, control_size()), as
  /// ControlNetworkImpl::step() has them. @param state (rows, state_size()), moved on. @param out (rows,
  /// control_size()); may be `control`. May be called from several threads, each with a workspace of its own.
  void step(const float* pose, const float* control, int64_t rows, float* state, float* out,
            Workspace& workspace) const;

 private:
  int64_t layers() const { return static_cast<int64_t>(lstm_.size()); }
  void run_lstm(size_t layer, int64_t block, int64_t first_row, int64_t rows, float* state, Workspace& workspace) const;

  int64_t pose_ = 0, control_ = 0, wide_ = 0, width_ = 0;
  PackedExperts pose_encoder_[2], control_encoder_[2], out_;
  std::vector<PackedExperts> lstm_;  ///< each block of columns has the four gates of 16 units
  std::vector<float> start_;
  int64_t multiplications_ = 0;  ///< of a row
};

}  // namespace inhabit::interact
