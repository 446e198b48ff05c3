#include "inhabit/forecast/forecast_clip.h"

#include <numeric>

#include "inhabit/body/fit.h"
#include "inhabit/error.h"
#include "inhabit/motion/feet.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/scene/sampling.h"

namespace inhabit {
namespace {

constexpr double kStep = 0.1;  // metres below the feet observed: who puts them there sat with feet up, or steps down

/// The prediction with clean feet, which go on from where they were observed.
Clip with_clean_feet(const Clip& past, const Clip& prediction) {
  Clip whole = prediction;
  whole.joints = torch::cat({past.joints, prediction.joints});
  whole.rotations = torch::cat({past.rotations, prediction.rotations});
  whole.trans = torch::cat({past.trans, prediction.trans});
  std::vector<int64_t> observed(static_cast<size_t>(past.frames()));
  std::iota(observed.begin(), observed.end(), 0);
  const double before = floor_under(past), after = floor_under(prediction);
  return slice(clean_feet(whole, observed, after < before - kStep ? after : before), past.frames(), whole.frames());
}

}  // namespace

ForecastClips forecast_clip(const ContactForecaster& forecaster, const Clip& clip, const Scene& scene,
                            const ForecastClipOptions& options, const std::string& subject) {
  torch::NoGradGuard no_grad;
  const ForecastConfig& config = forecaster.config();
  if (options.start > clip.frames())
    throw Error(subject, "frame " + std::to_string(options.start) + " is beyond the end (" +
                             std::to_string(clip.frames()) + " frames)");
  const int64_t asked = options.start < 0 ? clip.frames() : options.start;
  const Clip motion = resample(retarget(clip, subject), config.rate, subject);
  const int64_t start =
      std::min<int64_t>(motion.frames(), std::llround(static_cast<double>(asked) * config.rate / clip.rate));
  if (start < config.past)
    throw Error(subject, "has " + std::to_string(start) + " frames at " +
                             std::to_string(static_cast<int>(config.rate)) + " a second before the start; " +
                             std::to_string(config.past) + " are needed");

  ForecastClips out;
  out.past = slice(motion, start - config.past, start);
  if (motion.frames() > start)
    out.truth = slice(motion, start, std::min<int64_t>(motion.frames(), start + config.future));
  std::mt19937_64 random(options.seed);
  const torch::Tensor points = sample_points_near(scene, out.past.joints[config.past - 1][config.root], config.radius,
                                                  options.points > 0 ? options.points : config.points, random);
  out.forecast = forecaster.forecast(out.past.joints, points);

  out.prediction.rate = config.rate;
  out.prediction.joints = out.forecast.joints;
  const BodyFit body =
      fit_rotations(builtin_body(), out.prediction.joints, fit_shape(builtin_body(), out.past.joints));
  out.prediction.skeleton = shaped_skeleton(builtin_body(), body.betas);
  out.prediction.rotations = body.rotations;
  out.prediction.trans = body.trans;
  out.prediction.betas = body.betas;
  if (options.clean_feet) out.prediction = with_clean_feet(out.past, out.prediction);
  return out;
}

Scene assumed_floor(const Clip& clip) {
  const torch::Tensor path = clip.root_path(), low = std::get<0>(path.min(0)), high = std::get<0>(path.max(0)),
                      middle = (low + high) / 2;
  Scene scene =
      floor_scene(12.0 + (high - low).max().item<double>(), middle[0].item<double>(), middle[2].item<double>());
  // The lowest joint is the ball of a foot, some 2 cm above the sole.
  const double floor = clip.joints.select(2, 1).min().item<double>() - 0.02;
  scene.meshes[0].vertices.select(1, 1).add_(floor);
  return scene;
}

}  // namespace inhabit
