#pragma once
#include <torch/types.h>

#include <memory>
#include <vector>

namespace inhabit {

/// The processes (ranks) that train one model together, each on its part of every batch, over c10d: gloo on CPUs, NCCL
/// on GPUs where LibTorch has it.
class DataParallel {
 public:
  /// The group that `torchrun --no-python inhabit train ...` or `mpirun inhabit train ...` started this process in,
  /// from the environment: RANK and WORLD_SIZE (torchrun) or OMPI_COMM_WORLD_RANK and _SIZE (Open MPI), MASTER_ADDR
  /// (default 127.0.0.1) and MASTER_PORT (default 29500). Null where there is one process alone. Throws Error where
  /// they contradict each other, the others do not come within five minutes, or this build has no c10d.
  /// @param device cuda becomes the GPU of the local rank (LOCAL_RANK or OMPI_COMM_WORLD_LOCAL_RANK).
  static std::shared_ptr<DataParallel> from_environment(torch::Device& device);
  /// @param address,port of rank 0.
  DataParallel(int rank, int size, const std::string& address, int port, torch::Device device);
  ~DataParallel();
  DataParallel(const DataParallel&) = delete;
  DataParallel& operator=(const DataParallel&) = delete;

  /// Which of the processes this is, from 0.
  int rank() const { return rank_; }
  /// How many there are.
  int size() const { return size_; }
  /// Every tensor becomes its mean over the ranks; all ranks must call it with the same shapes. One message for all.
  void average(std::vector<torch::Tensor>& tensors) const;
  /// Every tensor becomes rank 0's.
  void broadcast(std::vector<torch::Tensor>& tensors) const;
  /// Returns when all ranks have called it.
  void wait_for_all() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  int rank_ = 0, size_ = 1;
};

}  // namespace inhabit
