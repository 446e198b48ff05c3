#pragma once
#include <memory>
#include <string>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

class SceneQuery;

/// Labels what a recorded body touches, from geometry alone: a joint is in contact where its capsule is within 3 cm of
/// the scene and it is slower than 0.3 m/s; a hand's target is the nearest place of what is no floor, within 20 cm of
/// the wrist.
class TouchLabels {
 public:
  /// `body` must outlive this. A scene without a floor by name (is_floor) is a scan: hands do not touch what lies under
  /// 4 cm over y = 0 and looks up (without_ground).
  TouchLabels(const Scene& scene, const BodyModel& body);
  ~TouchLabels();
  TouchLabels(const TouchLabels&) = delete;
  TouchLabels& operator=(const TouchLabels&) = delete;

  /// Sets contact and hand_targets. Needs rotations and trans on the standard skeleton.
  void label(Clip& clip) const;

 private:
  const BodyModel* body_;
  std::unique_ptr<SceneQuery> scene_, solids_;  ///< solids_: none where there is nothing but a floor
};

/// What label_actions calls what people do: stand, walk, run and sit.
const std::vector<std::string>& told_actions();

/// Sets action from the speed over the ground within half a second (walk over 0.35 m/s, run over 2 m/s) and the
/// contact of pelvis and thighs (sit).
void label_actions(Clip& clip);

/// (T, J) m/s: how fast joints move to the next frame; the last frame as the one before it.
torch::Tensor joint_speeds(const Clip& clip);

}  // namespace inhabit
