#include "inhabit/inbetween/evaluation_windows.h"

#include <memory>

#include "inhabit/error.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/scene/floor.h"

namespace inhabit::inbetween {

std::vector<Window> windows_of_data(const std::vector<std::string>& folders, const std::string& split,
                                    const Config& config, int64_t count) {
  const Data data(folders, split, config, config.frames);
  require_any_window(data.windows(), folders, split);
  std::vector<Window> out;
  for (const int64_t i : data.windows().spread(count)) out.push_back(data.window(i));
  return out;
}

std::vector<Window> windows_of_recordings(const std::vector<std::pair<std::string, Clip>>& recordings,
                                          const Scene& scene, const Config& config, int64_t count) {
  std::vector<Window> all;
  for (const auto& [file, recording] : recordings) {
    Clip clip = resample(retarget(recording, file), config.rate, file);
    const Scene around = scene.empty() ? assumed_floor(clip) : scene;
    const double floor = floor_under(clip, SceneQuery(around));
    clip = transformed(clip, {0, {0, -floor, 0}});
    const auto there = std::make_shared<const Scene>(raised(around, -floor));
    for (int64_t t = 0; t + config.frames <= clip.frames(); t += config.frames)
      all.push_back({file + " " + std::to_string(t), slice(clip, t, t + config.frames), {}, there});
  }
  if (all.empty())
    throw Error(recordings.front().first, "has no window of " + std::to_string(config.frames) + " frames");
  const auto most = static_cast<size_t>(count);
  if (all.size() <= most) return all;
  std::vector<Window> spread;
  for (size_t i = 0; i < most; ++i) spread.push_back(all[i * all.size() / most]);
  return spread;
}

}  // namespace inhabit::inbetween
