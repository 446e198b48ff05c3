#pragma once
#include <memory>
#include <vector>

#include "inhabit/scene/distance_field.h"

namespace inhabit::interact {

/// What of many points is inside a scene's meshes, and how deep: a distance field shows that nearly all are outside,
/// exact queries decide about the rest.
class Insides {
 public:
  /// The scene is not looked at later.
  explicit Insides(const Scene& scene);

  /// Points that are inside.
  struct Deep {
    std::vector<int64_t> rows;            ///< of the points that are inside
    std::vector<double> depths;           ///< metres
    std::vector<Eigen::Vector3d> places;  ///< the nearest of the surface
  };
  /// @param points (N, 3) float, metres, world
  Deep deep(const torch::Tensor& points) const;
  /// Metres that the deepest of them is inside; 0 where none is.
  double deepest(const torch::Tensor& points) const;

  /// Metres from the nearest of at least one point to the surface, negative inside, found among the dozen that the
  /// field has nearest. The scene must have a face.
  double least_distance(const torch::Tensor& points) const;

 private:
  std::unique_ptr<SceneQuery> query_;  ///< none where there is no face
  Eigen::AlignedBox3f box_;
  std::unique_ptr<DistanceField> field_;
};

}  // namespace inhabit::interact
