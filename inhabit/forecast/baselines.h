#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "inhabit/forecast/model_file.h"

namespace inhabit::forecast {

/// A trained network that the system is compared with.
struct Baseline {
  std::string stage;                           ///< of train(); its parameters are called stage + "_net."
  std::string row;                             ///< its name in the tables
  std::shared_ptr<torch::nn::Module> network;  ///< its weights
  /// World joints (B, T, J, 3) of observed ones (B, P, J, 3) and scene points (B, N, 3), origin at the root of the last
  /// observed frame.
  std::function<torch::Tensor(const torch::Tensor& past, const torch::Tensor& points)> forecast;
};

/// The baselines that are among `networks`, in the order of the tables.
std::vector<Baseline> baselines_of(const Networks& networks);

}  // namespace inhabit::forecast
