#pragma once
#include <torch/torch.h>

#include <string>

#include "inhabit/error.h"

namespace inhabit::nn {

/// "cpu", "cuda" or "cuda:1" as a device. Throws Error for other names, and where LibTorch has no such device.
inline torch::Device device_named(const std::string& name) {
  torch::Device device(torch::kCPU);
  try {
    device = torch::Device(name);
  } catch (const c10::Error&) {
    throw Error("device '" + name + "'", "is unknown; there are cpu and cuda");
  }
  if (device.is_cuda() &&
      (!torch::cuda::is_available() || device.index() >= static_cast<int>(torch::cuda::device_count())))
    throw Error("device '" + name + "'", "is not there, or this LibTorch was built without CUDA");
  if (!device.is_cuda() && !device.is_cpu()) throw Error("device '" + name + "'", "is unknown; there are cpu and cuda");
  return device;
}

}  // namespace inhabit::nn
