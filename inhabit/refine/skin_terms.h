#pragma once
#include <map>
#include <vector>

#include "inhabit/refine/depth_terms.h"
#include "inhabit/refine/scene_terms.h"

namespace inhabit::refine {

/// The skin of a body, each vertex with the ball of the body's volume (body_balls) that is under it: what is between
/// the two is flesh, and what of the scene is in the flesh is what the skin has gone into.
class Flesh {
 public:
  Flesh(const BodyModel& body, const torch::Tensor& betas, std::vector<BodyBall> balls);

  /// Terms that keep the skin from being deeper than `depth` in a scene, where it is or nearly is: those vertices that
  /// are deepest, some centimetres apart. A depth is measured from where the segment from ball to vertex enters a
  /// surface, also where the vertex has come out again behind something thin; where the ball itself is inside, from
  /// the surface that is nearest to it.
  /// @param poses frame by frame, one after the other
  /// @param points those of the problem, the same in every call, to which vertices are added as they are needed
  std::vector<PlaneTerm> planes(const SceneQuery& solid, const Poses& poses, double depth, double weight,
                                std::vector<Point>& points);

 private:
  std::vector<PlaneTerm> planes_of_some(const SceneQuery& solid, const Poses& poses, double depth, double weight,
                                        std::vector<Point>& points);
  void follow_limbs(const BodyModel& body, const Skin& skin);

  std::vector<Point> vertices_;
  std::vector<BodyBall> balls_;            // with the flesh around each for its radius
  std::vector<int> before_;                // of each ball the one that its limb comes from; -1 for none
  std::vector<std::vector<int>> covered_;  // vertices over each ball
  std::map<int, int> number_;              // of each vertex that is a point of the problem
};

}  // namespace inhabit::refine
