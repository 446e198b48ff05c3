#pragma once
#include <torch/types.h>

#include <functional>
#include <thread>
#include <vector>

/// What `run` gives to each of four threads that call it at the same time.
inline std::vector<torch::Tensor> four_at_once(const std::function<torch::Tensor()>& run) {
  std::vector<torch::Tensor> found(4);
  std::vector<std::thread> threads;
  for (torch::Tensor& out : found) threads.emplace_back([&run, &out] { out = run(); });
  for (std::thread& thread : threads) thread.join();
  return found;
}
