#include "inhabit/forecast/forecast_stream.h"

#include "inhabit/nn/each_person.h"

namespace inhabit::forecast {
namespace {

/// Seconds from the first of the observed frames to the last.
double observed_seconds(const Config& config) { return (config.past - 1) / config.rate; }

}  // namespace

ForecastStream::ForecastStream(std::shared_ptr<const ContactForecaster> forecaster, Scene scene,
                               const StreamOptions& options)
    : forecaster_(std::move(forecaster)),
      scene_(std::move(scene)),
      options_(options.forecast),
      poses_(options.poses, observed_seconds(forecaster_->config()), observed_seconds(forecaster_->config())) {
  options_.start = -1;
  options_.name = "person";
}

std::vector<StreamResult> ForecastStream::take() {
  const Config& config = forecaster_->config();
  return nn::each_person<StreamResult>(poses_.take(), [&](const PoseStream::Due& due) {
    return forecaster_->run(due.window->clip(config.rate, config.past), scene_, options_);
  });
}

}  // namespace inhabit::forecast
