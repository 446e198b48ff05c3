#pragma once
#include <torch/torch.h>

#include <memory>
#include <utility>
#include <vector>

namespace inhabit::anticipate {

/// Networks are on the CPU, where evaluation runs, while one lives.
struct OnCpu {
  torch::Device device;
  std::vector<std::shared_ptr<torch::nn::Module>> modules;

  OnCpu(torch::Device on, std::vector<std::shared_ptr<torch::nn::Module>> moved)
      : device(on), modules(std::move(moved)) {
    move_to(torch::kCPU);
  }
  ~OnCpu() { move_to(device); }
  OnCpu(const OnCpu&) = delete;
  OnCpu& operator=(const OnCpu&) = delete;

 private:
  void move_to(torch::Device where) {
    for (const auto& module : modules)
      if (module && !device.is_cpu()) module->to(where);
  }
};

}  // namespace inhabit::anticipate
