#include "inhabit/forecast/losses.h"

namespace inhabit::forecast {

torch::Tensor contact_map_loss(const torch::Tensor& predicted, const torch::Tensor& truth, const Config& config) {
  const double values = static_cast<double>(config.past + config.future) *
                        static_cast<double>(config.joints * truth.size(0) * truth.size(2));
  return torch::mse_loss(predicted, truth, torch::Reduction::Sum) / values;
}

MotionLosses motion_losses(const MotionForecast& forecast, const torch::Tensor& future,
                           const torch::Tensor& contact_points, const Config& config) {
  MotionLosses out;
  const torch::Tensor true_path = future.select(2, config.root);
  const torch::Tensor path = forecast.root_path.narrow(1, config.past, config.future);
  out.root = (path - true_path).square().sum(-1).mean();
  // Every row but the root's: mask instead of indexing, so that the root may be any joint.
  torch::Tensor others = torch::ones({config.joints, 1}, future.options());
  others[config.root] = 0;
  const torch::Tensor true_local = future - true_path.unsqueeze(2);
  out.local =
      ((forecast.local - true_local) * others).square().sum(-1).sum(-1).mean() / static_cast<double>(config.joints - 1);
  const torch::Tensor joints = forecast.local * others + path.unsqueeze(2);
  out.contact = (contact_points.select(3, 3) * (joints - contact_points.narrow(3, 0, 3)).square().sum(-1)).mean();
  out.total = config.training.root_weight * out.root + config.training.pose_weight * out.local +
              config.training.contact_weight * out.contact;
  return out;
}

}  // namespace inhabit::forecast
