#pragma once
#include <torch/types.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/forecast/model_file.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit::forecast {

/// A forecast and the contacts it was made from. World coordinates, metres.
struct Forecast {
  torch::Tensor joints;          ///< (T, J, 3)
  torch::Tensor points;          ///< (N, 3) the scene points that were looked at
  torch::Tensor contact_dct;     ///< (L*J, N) coefficients of the predicted contact maps, Eq. 5; undefined where joints
                                 ///< are wanted alone
  int64_t map_frames = 0;        ///< P+T, frames of the contact maps
  torch::Tensor contact_points;  ///< (T, J, 4) x y z, then whether the joint is in contact

  /// (P+T, J, N) predicted contact maps, Eq. 6: the larger part of the memory, so that they are made at each call.
  /// Throws Error where there are no coefficients.
  torch::Tensor contact_maps() const;
};

/// One of the ways in which the person may go on (hypotheses.h).
struct Hypothesis {
  torch::Tensor joints;    ///< (T, J, 3) as the network says
  Clip prediction;         ///< as Result::prediction
  Clip on_source;          ///< as Result::on_source
  double probability = 0;  ///< by the model, among all that it has
};

/// What is to be forecast, and how.
struct Options {
  int64_t start = -1;           ///< first predicted frame, counted in the clip; -1: its end
  int64_t points = 0;           ///< scene points looked at; 0: as the model was trained
  uint64_t seed = 1;            ///< draws the points
  bool refine = true;           ///< feet stand, nobody is inside the scene (refine_clip.h); `forecast` stays raw
  std::string name = "motion";  ///< what errors call the clip
  bool standard = false;        ///< the prediction is wanted on the standard skeleton alone
  /// The network's joints are wanted alone, on the standard skeleton: no body is fitted to them, nothing is refined and
  /// no coefficients of contact maps are kept, for streams. Result::prediction then has no rotations.
  bool joints_alone = false;
  int64_t samples = 1;  ///< over 1: so many ways to go on are wanted as well, the likeliest of the model's
};

/// A forecast as a motion, with what it was made from.
struct Result {
  Clip past;        ///< P frames
  Clip prediction;  ///< T frames: the network's joints, refined where asked for; rotations, trans and
                    ///< betas of the body fitted to them
  Clip on_source;   ///< the prediction on the clip's own skeleton, at its rate (motion/transfer.h); empty where
                    ///< Options::standard is set
  std::vector<Hypothesis> hypotheses;  ///< likeliest first, where Options::samples is over 1
  std::optional<Clip> truth;           ///< as many of the T frames as the clip has
  Forecast forecast;                   ///< what the networks said
  Scene scene;                 ///< what was looked at: the one given or, where that is empty, an assumed flat floor
  bool floor_assumed = false;  ///< nothing was given
};

/// Contact-aware motion forecasting: the second that was observed and a room in, the next two seconds out. On the CPU.
/// Safe to use from several threads.
///
///   const auto forecaster = forecast::ContactForecaster::load("forecast-compact.safetensors");
///   forecast::Result r = forecaster.run(clip, scene);   // r.prediction
class ContactForecaster {
 public:
  /// Throws Error naming the file where it is no such model or lacks one of the two networks.
  static ContactForecaster load(const std::string& path);
  /// Throws Error where one of the two networks is missing.
  explicit ContactForecaster(const Networks& networks);
  ~ContactForecaster();
  ContactForecaster(ContactForecaster&&) noexcept;  ///< what was moved from may only be destroyed

  /// Rates, lengths and sizes that the networks were made with.
  const Config& config() const;

  /// Observes the second before options.start of a clip on any skeleton that maps to the standard one, at any rate, and
  /// predicts what comes. @param scene as read; without meshes and points a flat floor under the feet is assumed.
  /// Throws Error where less than a second lies before the start, nothing of the scene is near, or an option is out of
  /// range.
  Result run(const Clip& clip, const Scene& scene, const Options& options = {}) const;

  /// The networks alone. @param past (P, J, 3) at config().rate; @param points (N, 3) scene points near the person
  /// (points_near, sample_points_near).
  Forecast predict(const torch::Tensor& past, const torch::Tensor& points) const;

  /// How many ways to go on the model has; 0: the one forecast alone.
  int64_t hypotheses() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::forecast
