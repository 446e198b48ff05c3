#include "inhabit/inbetween/losses.h"

#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/features.h"

namespace inhabit {

using torch::Tensor;

std::vector<std::pair<std::string, Tensor>> inbetween_loss_terms(const Tensor& predicted, const Tensor& truth,
                                                                 const Tensor& bones, const Tensor& mean,
                                                                 const Tensor& deviation,
                                                                 const InbetweenConfig& config) {
  constexpr double kUnit = 0.3;  // metres
  const auto joints_of = [&](const Tensor& features) {
    return feature_joints(features.transpose(1, 2) * deviation + mean, bones) / kUnit;  // (B, T, 22, 3)
  };
  const Tensor simple = (truth - predicted).square().mean();  // Eq. 1
  const Tensor moved = joints_of(truth) - joints_of(predicted);
  const Tensor joints = moved.square().mean();               // Eq. 2
  const Tensor velocity = moved.diff(1, 1).square().mean();  // Eq. 3
  return {{"total", simple + config.joints_weight * joints + config.velocity_weight * velocity},
          {"simple", simple},
          {"joints", joints},
          {"velocity", velocity}};
}

}  // namespace inhabit
