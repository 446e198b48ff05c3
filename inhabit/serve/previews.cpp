#include "inhabit/serve/previews.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/motion/resample.h"

namespace inhabit::serve {
namespace {

constexpr double kSpeed = 0.9;    // metres a second between poses
constexpr double kTurn = 1.8;     // radians a second
constexpr double kFastest = 1.4;  // metres a second, where one window of the model would not do

/// A pose every `gap` seconds of a motion on the standard joints.
void add_ghosts(const Clip& motion, double gap, uint8_t track, std::vector<Ghost>& out) {
  for (int k = 1;; ++k) {
    const auto at = static_cast<int64_t>(std::lround(k * gap * motion.rate)) - 1;
    if (at >= motion.frames()) return;
    out.push_back({static_cast<float>(k * gap), track, frame_of(motion, at)});
  }
}

}  // namespace

std::vector<Ghost> forecast_ghosts(const World& world, const Clip& recent) {
  if (!world.forecaster) throw Error("forecast", "has no model here");
  forecast::Options options;
  options.standard = true;
  options.name = "person";
  const forecast::Result result = world.forecaster->run(recent, world.scene, options);
  std::vector<Ghost> out;
  add_ghosts(result.prediction, 0.5, 0, out);
  return out;
}

std::vector<Ghost> future_ghosts(const World& world, const Clip& recent, uint64_t seed) {
  if (!world.anticipator) throw Error("futures", "have no model here");
  anticipate::Options options;
  options.samples = 4;
  options.seconds = 3;
  options.seed = seed;
  options.standard = true;
  options.name = "person";
  const anticipate::Result result = world.anticipator->run(recent, {}, options);
  std::vector<Ghost> out;
  for (size_t i = 0; i < result.futures.size(); ++i) add_ghosts(result.futures[i], 1, static_cast<uint8_t>(i), out);
  return out;
}

Clip motion_to(const World& world, const Frame& from, const Frame& to) {
  if (!world.inbetweener) throw Error("pose", "has no model of in-betweening here");
  const double rate = world.inbetweener->config().rate;
  const double far = (to.trans - from.trans).norm(), angle = from.rotation[0].angularDistance(to.rotation[0]);
  const int64_t longest = world.inbetweener->config().frames - 1;
  if (far > kFastest * static_cast<double>(longest) / rate)
    throw Error("pose", fmt::format("is {:.1f} m away: at most {:.1f} m can be filled in", far,
                                    kFastest * static_cast<double>(longest) / rate));
  const double seconds = std::max({1.2, far / kSpeed + 0.5, angle / kTurn + 0.5});
  const int64_t frames = std::min(std::llround(seconds * rate), static_cast<long long>(longest)) + 1;
  std::vector<Frame> poses(static_cast<size_t>(frames), from);
  poses.back() = to;
  Clip keys = clip_of(poses, world.person);
  keys.rate = rate;
  inbetween::Options options;
  options.keys = {0, frames - 1};
  options.standard = true;
  options.name = "pose";
  const Clip motion = world.inbetweener->run(keys, world.scene, options).motion;
  return rate == 30 ? motion : resample(motion, 30);
}

}  // namespace inhabit::serve
