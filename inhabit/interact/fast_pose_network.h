#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/interact/expert_kernel.h"
#include "inhabit/interact/pose_network.h"
#include "inhabit/interact/work_stages.h"

namespace inhabit::interact {

/// Inference-only evaluation of a PoseNetwork (ours, NSM, NSM+Control) on the CPU: the same outputs as
/// PoseNetworkImpl::forward() in evaluation mode to 1e-4 (weights in 16 bits where these do, expert_kernel.h), without
/// a graph and without allocating. Copies share the weights.
class FastPoseNetwork {
 public:
  explicit FastPoseNetwork(const PoseNetwork& network);

  /// What forward() works in: of one thread at a time. It grows with the first call of so many rows.
  struct Workspace {
    std::vector<float> codes, layers, gates;
    WorkStages stages;
  };

  /// @param x (rows, sizes().row), standardised. @param y (rows, sizes().outputs), standardised. May be called from
  /// several threads, each with a workspace of its own.
  void forward(const float* x, int64_t rows, float* y, Workspace& workspace) const;
  /// (B, row) -> (B, outputs).
  torch::Tensor forward(const torch::Tensor& x) const;

  const PoseSizes& sizes() const { return sizes_; }

 private:
  /// A layer and where its rows come from and go to.
  struct Piece {
    PackedExperts layer;
    enum class Store { kInput, kLayers, kCodes, kGates, kOutput } from, to;
    int64_t from_column = 0, to_column = 0;
    Activation activation = Activation::kElu;
    bool gated = false;
    int64_t first_block = 0;  ///< blocks of the stage's pieces before it
  };
  using Stage = std::vector<Piece>;

  void add(size_t stage, Piece piece);
  void run(const Piece& piece, int64_t block, int64_t first_row, int64_t rows, const float* x, float* y,
           Workspace& workspace) const;

  PoseSizes sizes_;
  std::vector<Stage> stages_;
  int64_t code_ = 0, wide_ = 0;  ///< columns of the workspace's rows
  int64_t multiplications_ = 0;  ///< of a row
};

}  // namespace inhabit::interact
