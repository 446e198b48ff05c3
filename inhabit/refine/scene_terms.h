#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/refine/trajectory.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/query.h"
#include "inhabit/scene/scene.h"
#include "inhabit/scene/surface_place.h"

namespace inhabit::refine {

/// A ball of the body's volume: a place on the axis of one of its capsules.
struct BodyBall {
  Point point;        ///< its middle, in the frame of the capsule's joint
  double radius = 0;  ///< metres
  double give = 0;    ///< metres that it may be inside: skin that is sat, leaned or rested on
};

/// Balls along the capsules of a body with shape `betas`, a radius apart and at most 6 cm; those of hands go on to the
/// fingertips, and thumbs have one, so that no skin of a hand is more than 3 cm outside of them.
std::vector<BodyBall> body_balls(const BodyModel& body, const torch::Tensor& betas);

/// What a body is kept out of, and what it stands on.
class Surroundings {
 public:
  /// Floors and rugs (meshes called so) are stood on only; all else is kept out of too. Point clouds count for neither.
  explicit Surroundings(const Scene& scene);
  ~Surroundings();

  /// Heights of the highest surface that is not above `places` by more than 0.3 m nor under them by more than 1 m; NaN
  /// where there is none. What is above a place and above most of the floors is furniture: there it is the surface
  /// below.
  std::vector<double> floor_under(const Track& places) const;

  /// Whether nothing is there to be touched.
  bool empty() const { return floor_ == nullptr && solid_ == nullptr; }

  /// What is nearest to each of `places`, floors and all else. Not to be asked where all is empty.
  std::vector<SurfacePlace> surfaces_near(const Track& places) const;

  /// What a body is kept out of; null where there is nothing.
  const SceneQuery* solid() const { return solid_.get(); }

  /// One term a ball that is inside the scene or nearer to it than its radius and `reach`: to stay on the outer side
  /// of the plane at the nearest place of the surface, or, where it goes right through something thin, beside that.
  /// What is slow may rest on a surface and be in it by the ball's `give`, but for arms of somebody who walks. @param
  /// first_ball number of the first ball among the problem's points. @param rate poses a second; 0: they do not follow
  /// one another, and each is on its own
  std::vector<PlaneTerm> planes(const std::vector<BodyBall>& balls, int first_ball, const Poses& poses, double rate,
                                double reach, double weight) const;

 private:
  std::unique_ptr<SceneQuery> floor_, solid_;
};

/// The Surroundings of several motions in one scene: those that have the same are given the same, made once. Safe to
/// use from several threads.
class SharedSurroundings {
 public:
  /// @param scene later changes of it are not seen
  explicit SharedSurroundings(const Scene& scene) : scene_(scene), rooms_(scene) {}

  /// The scene around a motion whose pelvis goes along `path` (T, 3), its rooms looking in (rooms_looking_in). Lives as
  /// long as this does.
  const Surroundings& around(const torch::Tensor& path) const;

 private:
  Scene scene_;
  Rooms rooms_;
  mutable std::mutex mutex_;
  mutable std::map<std::vector<size_t>, Surroundings> made_;  // by the meshes that are turned inside out
};

}  // namespace inhabit::refine
