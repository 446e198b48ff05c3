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

ArticulatedLosses articulated_losses(const MotionForecast& forecast, const torch::Tensor& last,
                                     const torch::Tensor& future, const torch::Tensor& contact_points,
                                     const Config& config) {
  const auto distance = [](const torch::Tensor& apart) { return (apart.square().sum(-1) + 1e-10).sqrt(); };
  const torch::Tensor joints = forecast_joints(forecast, config.root);
  const torch::Tensor apart = joints - future, path = apart.select(2, config.root);
  const torch::Tensor others = torch::cat({apart.slice(2, 0, config.root), apart.slice(2, config.root + 1)}, 2);
  const auto steps = [&](const torch::Tensor& all) {
    return all - torch::cat({last.unsqueeze(1), all.slice(1, 0, all.size(1) - 1)}, 1);
  };
  ArticulatedLosses out;
  out.path = distance(path).mean();
  out.pose = distance(others - path.unsqueeze(2)).mean();
  out.contact = (contact_points.select(3, 3) * (joints - contact_points.narrow(3, 0, 3)).square().sum(-1)).mean();
  out.velocity = distance(steps(joints) - steps(future)).mean();
  const Config::Training& t = config.training;
  out.total = t.root_weight * out.path + t.pose_weight * out.pose + t.contact_weight * out.contact +
              t.velocity_weight * out.velocity;
  return out;
}

}  // namespace inhabit::forecast
