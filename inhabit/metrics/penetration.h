#pragma once
#include <string>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

class SceneQuery;

/// How deep the body is in the scene, and where that happens.
struct Penetration {
  double depth = 0;    ///< metres; 0 when the body is nowhere inside
  int64_t frame = -1;  ///< of the deepest place
  int joint = -1;      ///< whose capsule it is
  std::string object;  ///< name of the mesh nearest to that place
};

/// The deepest that any of the body's capsules gets into the scene's meshes in any frame. The floor (meshes called
/// "floor") does not count, nor does what is sat or leaned on, while it is: the object nearest to the root when
/// pelvis, hips or spine are labelled to be in contact, and going down or up (actions sit_down and stand_up next
/// to such frames or to the clip's ends). Objects are told by name (scene/objects.h). Needs clip.rotations and
/// clip.trans on the standard skeleton. Capsule axes are sampled every 3 cm or finer.
Penetration deepest_penetration(const Clip& clip, const BodyModel& body, const Scene& scene);

/// (T, capsules) metres that each of the body's capsules reaches into what `query` knows; negative when apart.
torch::Tensor capsule_depths(const Clip& clip, const BodyModel& body, const SceneQuery& query);

/// For each frame the name of the object sat or leaned on, empty where there is none (see deepest_penetration).
std::vector<std::string> supporting_objects(const Clip& clip, const Scene& scene);

/// How far the worst joint angle is beyond the body's limits, radians of an axis-angle component; 0 within.
struct LimitExcess {
  double radians = 0;  ///< of the worst joint in the worst frame
  int64_t frame = -1;  ///< where that is; -1: nowhere
  int joint = -1;      ///< which it is; -1: none
};
/// The worst excess over all frames and over all joints of the clip that the body has but the root. Zero without
/// rotations.
LimitExcess beyond_limits(const Clip& clip, const BodyModel& body);

/// How well labelled hand contacts meet the scene.
struct HandContact {
  int64_t contacts = 0;   ///< frames and hands that are labelled
  double target_gap = 0;  ///< metres between labelled point and surface, the largest
  double hand_gap = 0;    ///< metres between the hand's skin and the surface, the largest
};
/// How well Clip::hand_targets meet the obstacles' meshes. Zeros where the clip has no targets or the scene no mesh;
/// hand_gap stays 0 without rotations.
HandContact hand_contact(const Clip& clip, const BodyModel& body, const Scene& scene);

}  // namespace inhabit
