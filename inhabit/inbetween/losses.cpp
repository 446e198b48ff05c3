#include "inhabit/inbetween/losses.h"

#include "inhabit/body/skeleton.h"
#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/features.h"

namespace inhabit::inbetween {

using torch::Tensor;

std::vector<std::pair<std::string, Tensor>> loss_terms(const Tensor& predicted, const Tensor& truth,
                                                       const Tensor& bones, const FeatureScale& scale,
                                                       const Config& config) {
  constexpr double kUnit = 0.3;    // metres
  constexpr double kStill = 0.01;  // metres that a standing foot moves at most from one frame to the next
  const auto in_units = [&](const Tensor& features) { return scale.from_network(features.transpose(1, 2)); };
  const Tensor simple = (truth - predicted).square().mean();       // Eq. 1
  const Tensor here = feature_joints(in_units(predicted), bones);  // (B, T, 22, 3)
  const Tensor there = in_units(truth).slice(2, kJointFeature).reshape(here.sizes());
  const Tensor moved = (there - here) / kUnit;
  const auto steps_of_feet = [&](const Tensor& joints) {  // (B, T - 1, 4, 3)
    return foot_positions(joints).diff(1, 1);
  };
  const Tensor standing = steps_of_feet(there).norm(2, 3, true) < kStill;
  const Tensor joints = moved.square().mean();               // Eq. 2
  const Tensor velocity = moved.diff(1, 1).square().mean();  // Eq. 3
  const Tensor feet = (steps_of_feet(here) / kUnit * standing).square().mean();
  return {{"total", simple + config.training.joints_weight * joints + config.training.velocity_weight * velocity +
                        config.training.feet_weight * feet},
          {"simple", simple},
          {"joints", joints},
          {"velocity", velocity},
          {"feet", feet}};
}

}  // namespace inhabit::inbetween
