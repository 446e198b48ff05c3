#include "inhabit/forecast/contact_forecaster.h"

#include "inhabit/error.h"
#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/fast_motion_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/forecast/window_frame.h"

namespace inhabit::forecast {

struct ContactForecaster::Impl {
  Config config;
  mutable FastContactNetwork contact;
  FastMotionNetwork motion;
};

ContactForecaster::ContactForecaster(const Networks& networks)
    : impl_(std::make_unique<Impl>(
          Impl{networks.config, FastContactNetwork(networks.contact), FastMotionNetwork(networks.motion)})) {}
ContactForecaster::~ContactForecaster() = default;
ContactForecaster::ContactForecaster(ContactForecaster&&) noexcept = default;

ContactForecaster ContactForecaster::load(const std::string& path) {
  Networks networks = load_networks(path);
  if (networks.contact.is_empty() || networks.motion.is_empty())
    throw Error(path, "lacks the contact or the motion network: train both stages");
  return ContactForecaster(networks);
}

const Config& ContactForecaster::config() const { return impl_->config; }

Forecast ContactForecaster::forecast(const torch::Tensor& past, const torch::Tensor& points) const {
  torch::NoGradGuard no_grad;
  const Config& c = config();
  if (past.sizes() != torch::IntArrayRef({c.past, c.joints, 3}))
    throw Error("the forecaster observes (" + std::to_string(c.past) + ", " + std::to_string(c.joints) +
                ", 3) joints, not another shape");
  const WindowFrame frame = window_frame(past, c);
  const torch::Tensor observed = frame.to_window(past).unsqueeze(0), scene = frame.to_window(points).unsqueeze(0);
  const torch::Tensor dct = impl_->contact.forward(scene, contact_features(scene, observed, c), observed);
  Forecast out;
  out.contact_maps = contact_maps_from_dct(dct, c)[0];
  torch::Tensor contacts = contact_points(scene, dct, c);
  out.joints = frame.to_world(forecast_joints(impl_->motion.forward(observed, contacts), c.root)[0]);
  const torch::Tensor touching = contacts[0].narrow(2, 3, 1);
  out.contact_points = torch::cat({frame.to_world(contacts[0].narrow(2, 0, 3)) * touching, touching}, 2);
  out.points = points;
  return out;
}

}  // namespace inhabit::forecast
