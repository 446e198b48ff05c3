#include "inhabit/forecast/motion_of.h"

#include <memory>

#include "inhabit/forecast/fast_motion_network.h"

namespace inhabit::forecast {

Motion motion_of(const Networks& networks, Contacts contacts) {
  const bool any = contacts != Contacts::none, predicted = contacts == Contacts::predicted;
  if (!networks.articulated.is_empty()) {
    return [network = networks.articulated, any, predicted](const torch::Tensor& past,
                                                            const torch::Tensor& contact_points) mutable {
      torch::NoGradGuard no_grad;
      const Config& c = network->config;
      const torch::Tensor points = any ? contact_points : torch::zeros({past.size(0), c.future, c.joints, 4});
      return forecast_joints(network->forward(past, points, contact_conditioning(past.size(0), any, predicted)),
                             c.root);
    };
  }
  const MotionNetwork& network = any ? networks.motion : networks.no_contact;
  if (network.is_empty()) return {};
  return [fast = std::make_shared<const FastMotionNetwork>(network), root = network->config.root](
             const torch::Tensor& past, const torch::Tensor& contact_points) {
    return forecast_joints(fast->forward(past, contact_points), root);
  };
}

Hypothesize hypothesize_of(const Networks& networks) {
  if (networks.hypotheses.is_empty() || networks.articulated.is_empty()) return {};
  return [network = networks.hypotheses, articulated = networks.articulated](
             const torch::Tensor& past, const torch::Tensor& contact_points) mutable {
    const torch::NoGradGuard no_gradients;
    return network->forward(articulated,
                            articulated->see(past, contact_points, contact_conditioning(past.size(0), true, true)));
  };
}

}  // namespace inhabit::forecast
