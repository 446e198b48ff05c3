#include "inhabit/forecast/forecast_stream.h"

#include <optional>

#include "inhabit/error.h"
#include "inhabit/nn/one_blas_thread.h"
#include "inhabit/nn/parallel_chunks.h"

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
  const std::vector<PoseStream::Due> due = poses_.take();
  std::vector<StreamResult> out(due.size());
  std::optional<nn::OneBlasThread> one;  // a person on each core
  if (due.size() > 1) one.emplace();
  nn::parallel_chunks(static_cast<int64_t>(due.size()), [&](int64_t chunk) {
    const auto i = static_cast<size_t>(chunk);
    const Config& config = forecaster_->config();
    out[i].person = due[i].person;
    out[i].time = due[i].time;
    try {
      out[i].result = forecaster_->run(due[i].window->clip(config.rate, config.past), scene_, options_);
    } catch (const Error& error) {
      out[i].error = error.what();
    }
  });
  return out;
}

}  // namespace inhabit::forecast
