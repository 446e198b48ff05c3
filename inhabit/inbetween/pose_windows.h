#pragma once
#include <memory>
#include <string>
#include <vector>

#include "inhabit/data/window_set.h"
#include "inhabit/inbetween/poses.h"
#include "inhabit/inbetween/scene_probe.h"

namespace inhabit::inbetween {

struct Config;

/// A window of motion and the scene it is in.
struct PoseWindow {
  Poses poses;
  SceneDistances scene;
};

/// Windows of native data sets as residual motion is trained on them. Motion is read once and kept (80 KB a second);
/// distances to scenes are found where they are asked for. Safe to use from several threads.
class PoseWindows {
 public:
  /// @param folders, split, stride as Data takes them.
  PoseWindows(const std::vector<std::string>& folders, const std::string& split, const Config& config, int64_t stride);
  ~PoseWindows();
  PoseWindows(const PoseWindows&) = delete;
  PoseWindows& operator=(const PoseWindows&) = delete;

  const WindowSet& windows() const;
  int64_t size() const { return windows().size(); }
  PoseWindow window(int64_t index, bool mirrored) const;
  /// Windows of recorded motion (data sets that `inhabit synth fit` made) and of generated motion.
  const std::vector<int64_t>& recorded() const;
  const std::vector<int64_t>& generated() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::inbetween
