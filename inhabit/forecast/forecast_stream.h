#pragma once
#include <memory>
#include <string>
#include <vector>

#include "inhabit/forecast/contact_forecaster.h"
#include "inhabit/motion/pose_stream.h"

namespace inhabit::forecast {

/// How poses come in, and what is made of them.
struct StreamOptions {
  PoseStreamOptions poses = {};            ///< joints, rates, gaps
  Options forecast{.joints_alone = true};  ///< start and name are not looked at
};

/// A person's forecast.
struct StreamResult {
  std::string person;  ///< as push() called them
  double time = 0;     ///< seconds: the time stamp of the last pose; frame k of the forecast is (k + 1) / rate later
  Result result;       ///< as ContactForecaster::run() gives it for the second that ends there
  std::string error;   ///< why there is none, one line; empty: there is one
  std::string doubt;   ///< of the first result of a person, what is implausible of their poses; empty: nothing is
};

/// Forecasts of people whose joints come in one pose at a time. Time stamps are in seconds, in any order between people
/// and at any times; poses may be missing, and joints of them (rows that are not finite). Memory does not grow. Not for
/// several threads at once.
///
///   forecast::ForecastStream stream(forecaster, scene);
///   stream.push("anna", time, joints);                                    // (22, 3) metres, +Y up
///   for (const forecast::StreamResult& r : stream.take()) use(r.person, r.time, r.result.forecast.joints);
class ForecastStream {
 public:
  /// @param scene as ContactForecaster::run() takes it. Throws Error naming the option that is out of range.
  ForecastStream(std::shared_ptr<const ContactForecaster> forecaster, Scene scene, const StreamOptions& options = {});

  /// Throws Error as PoseStream::push() does; the stream goes on.
  void push(const std::string& person, double time, const torch::Tensor& joints) { poses_.push(person, time, joints); }
  /// Whether take() would give this person a forecast.
  bool due(const std::string& person) const { return poses_.due(person); }

  /// The forecasts that are due since the last call, by person, from each one's latest pose: on LibTorch's number of
  /// threads, a person on each. What cannot be forecast (nothing of the scene is near) says why.
  std::vector<StreamResult> take();

  /// The poses that are kept.
  const PoseStream& poses() const { return poses_; }

 private:
  std::shared_ptr<const ContactForecaster> forecaster_;
  Scene scene_;
  Options options_;
  PoseStream poses_;
};

}  // namespace inhabit::forecast
