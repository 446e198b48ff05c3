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
  Poses poses;           ///< (config.frames) as recorded, in the room's own world
  SceneDistances scene;  ///< of the room, the floor at height 0
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

  const WindowSet& windows() const;                  ///< where the windows are in the data sets
  int64_t size() const { return windows().size(); }  ///< how many windows there are
  /// One of them. @param mirrored with its scene: x becomes -x. @param pace how much faster than recorded, as far as
  /// the clip is long enough, for which the window may begin earlier
  PoseWindow window(int64_t index, bool mirrored, double pace = 1) const;
  /// Indices of the windows of recorded motion (data sets that `inhabit synth fit` made).
  const std::vector<int64_t>& recorded() const;
  const std::vector<int64_t>& generated() const;  ///< indices of all other windows

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::inbetween
