#pragma once
#include <torch/types.h>

#include <memory>
#include <string>

#include "inhabit/forecast/model_file.h"

namespace inhabit::forecast {

/// A forecast and the contacts it was made from. World coordinates, metres.
struct Forecast {
  torch::Tensor joints;          ///< (T, J, 3)
  torch::Tensor points;          ///< (N, 3) the scene points that were looked at
  torch::Tensor contact_maps;    ///< (P+T, J, N) predicted contact maps, Eq. 6
  torch::Tensor contact_points;  ///< (T, J, 4) x y z, then whether the joint is in contact
};

/// Contact-aware motion forecasting: the second that was observed and a room in, the next two seconds out. On the CPU,
/// by the fast networks; keeps their workspaces, so use one instance per thread.
///
///   ContactForecaster forecaster = ContactForecaster::load("forecast.safetensors");
///   Forecast f = forecaster.forecast(past, points);   // past (30, 22, 3), points (N, 3)
class ContactForecaster {
 public:
  static ContactForecaster load(const std::string& path);
  explicit ContactForecaster(const Networks& networks);
  ~ContactForecaster();
  ContactForecaster(ContactForecaster&&) noexcept;

  const Config& config() const;
  /// @param past (P, J, 3) at config().rate; @param points (N, 3) scene points near the person (points_near,
  /// sample_points_near).
  Forecast forecast(const torch::Tensor& past, const torch::Tensor& points) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::forecast
