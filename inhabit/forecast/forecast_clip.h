#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "inhabit/forecast/contact_forecaster.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

/// A forecast as motion: what was observed, what is predicted, what really happened where the clip goes on.
struct ForecastClips {
  Clip past;        ///< P frames
  Clip prediction;  ///< T frames: the network's joints, feet cleaned where asked for; rotations, trans and
                    ///< betas of the body fitted to them
  Clip last;        ///< the last observed frame, its rotations found as those of `prediction` (motion/transfer.h)
  std::optional<Clip> truth;  ///< as many of the T frames as the clip has
  Forecast forecast;
};

struct ForecastClipOptions {
  int64_t start = -1;      ///< first predicted frame, counted in `clip`; -1: its end
  int64_t points = 0;      ///< scene points looked at; 0: as the model was trained
  uint64_t seed = 1;       ///< draws the points
  bool clean_feet = true;  ///< feet stand and are lifted (motion/feet.h); `forecast` stays as the network says
};

/// Observes the second before frame `start` of a clip on any skeleton that maps to the standard one, at any rate, and
/// predicts what comes.
/// @param subject names the clip in errors. Throws Error where less than a second lies before `start` or nothing of the
/// scene is near.
ForecastClips forecast_clip(const ContactForecaster& forecaster, const Clip& clip, const Scene& scene,
                            const ForecastClipOptions& options, const std::string& subject);

/// The floor that is assumed where no scene is given: flat, under the lowest place of the feet, around where the person
/// is.
Scene assumed_floor(const Clip& clip);

}  // namespace inhabit
