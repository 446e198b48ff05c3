#pragma once
#include <torch/types.h>

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/distance_field.h"
#include "inhabit/scene/query.h"

namespace inhabit {

/// How deep a vertex of the skin must be inside the scene to collide, metres. Skin that carries weight or touches on
/// purpose (that of pelvis, thighs, spine, forearms and hands: supporting_skin) is soft: people who sit, lean and touch
/// in generated rooms are up to 4 cm inside what supports them, a forearm on an armrest sometimes more. Elsewhere 1 cm
/// covers the inaccuracy of meshes. By this measure 1.1 % of the frames of true motion in generated test rooms collide,
/// none of recordings in rooms fitted around them.
inline constexpr double kSupportedDepth = 0.04,  ///< of supporting_skin
    kCollisionDepth = 0.01;                      ///< of all other skin

/// How deep the skin may be inside the scene before it collides, metres.
struct CollisionTolerance {
  double supported = kSupportedDepth;  ///< supporting_skin
  double other = kCollisionDepth;      ///< all other skin
};
/// Without tolerance every vertex inside the scene collides.
inline constexpr CollisionTolerance kNoTolerance = {0, 0};

/// (V) bool: vertices that kSupportedDepth holds for, by the joint that moves each most.
torch::Tensor supporting_skin(const BodyModel& body);

/// Frames of a motion against the scene.
struct Collision {
  torch::Tensor depth;     ///< (T) metres that the deepest vertex that collides is inside; 0 where none does
  torch::Tensor vertices;  ///< (T) fraction of all vertices that collide
  torch::Tensor deepest;   ///< (T, 3) metres, where that vertex is; 0 where none does

  /// Over the frames in `mask` (T) bool, over all where it is undefined; 0 where it has none.
  double frame_ratio(const torch::Tensor& mask = {}) const;   ///< fraction of frames with a vertex that collides
  double vertex_ratio(const torch::Tensor& mask = {}) const;  ///< mean of `vertices`
  double penetration(const torch::Tensor& mask = {}) const;   ///< metres, the largest of `depth`
};

/// Measures skinned bodies against one scene. Floor and rugs (meshes called so, see object_of_mesh) do not count: feet
/// stand on them. All else does, seats too, so that no label of who sits where is needed and a body that slides through
/// a chair on its way to it collides. Solid defines what is inside; nothing is inside a point cloud. A distance
/// field around the motion shows that nearly all of the skin is outside, patch by patch and then vertex by vertex;
/// exact queries decide about the rest.
class CollisionMeter {
 public:
  /// `body` must outlive this.
  CollisionMeter(const BodyModel& body, const Scene& scene);

  /// Needs clip.rotations on the body's joints. The body has the clip's betas and stands with its root joint at the
  /// clip's.
  Collision measure(const Clip& clip) const;
  /// The same by several tolerances, one after the other; little dearer than by one.
  std::vector<Collision> measure(const Clip& clip, const std::vector<CollisionTolerance>& tolerances) const;

  /// The object (scene/objects.h) of the surface nearest to each of (N, 3) points; "" where nothing counts.
  std::vector<std::string> nearest_objects(const torch::Tensor& points) const;

  /// (T) bool: the frames with a vertex that collides, those of measure(clip).depth > 0. Sooner: the vertex that the
  /// field says is deepest mostly decides about a frame.
  torch::Tensor colliding_frames(const Clip& clip, const CollisionTolerance& tolerance = {}) const;

  /// (T) bool: the frames in which the skin is inside the scene or nearer to it than `distance` metres.
  torch::Tensor near_frames(const Clip& clip, double distance) const;

 private:
  /// Skin vertices that may be inside the scene, or nearer to it than `margin`: their places (N, 3), frames (N),
  /// numbers (N) and whether they are known to be inside (N).
  struct Candidates {
    torch::Tensor points, frames, vertices, inside;
  };
  Candidates candidates(const Clip& clip, float margin) const;
  /// Metres that the candidates in `rows` are inside the scene, by exact queries; 0 of those that are no deeper than
  /// `least` has for their vertex (V).
  std::vector<float> depths(const Candidates& found, const std::vector<int64_t>& rows,
                            const std::vector<float>& least) const;
  /// (V) metres that a tolerance leaves each vertex.
  std::vector<float> allowed(const CollisionTolerance& tolerance) const;

  const BodyModel* body_;
  std::vector<std::vector<int64_t>> patches_;  ///< vertices that lie together on the body
  torch::Tensor supporting_;                   ///< (V) bool, of supporting_skin
  std::unique_ptr<SceneQuery> query_;          ///< none where nothing counts
  std::vector<std::string> objects_;           ///< of each mesh that does
  std::optional<DistanceField> field_;         ///< where the boxes are
  std::vector<Eigen::AlignedBox3f> boxes_;     ///< around each body of the scene, then the cloud
};

}  // namespace inhabit
