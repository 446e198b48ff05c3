#pragma once
#include <torch/types.h>

#include <limits>
#include <memory>

#include "inhabit/scene/scene.h"
#include "inhabit/scene/solid.h"

namespace inhabit {

/// The places of a scene nearest to N points. A row whose point was not finite holds NaN and -1.
struct ClosestPoints {
  torch::Tensor points;     ///< (N, 3) metres
  torch::Tensor distances;  ///< (N) metres, not negative
  torch::Tensor
      normals;  ///< (N, 3) unit normal of the face by the right-hand rule, as the file has it; 0 for a cloud's point
  torch::Tensor mesh;  ///< (N) int64 index into scene.meshes; -1 where the nearest is a point of the cloud
  torch::Tensor face;  ///< (N) int64 index into that mesh's faces, or into scene.points
};

/// What N rays meet first. Rows without a hit hold infinity (distances), 0 and -1.
struct RayHits {
  torch::Tensor hit;        ///< (N) bool
  torch::Tensor distances;  ///< (N) metres along the ray
  torch::Tensor points;     ///< (N, 3) metres
  torch::Tensor normals;    ///< (N, 3) unit, right-hand rule
  torch::Tensor mesh;       ///< (N) int64
  torch::Tensor face;       ///< (N) int64
};

/// Answers questions about where a scene's surfaces are, many at a time and on all of torch's threads, from a bounding
/// volume hierarchy (Embree) over its triangles and a k-d tree (nanoflann) over its point cloud. Points are (N, 3)
/// float, metres, world. Rays see triangles only. Later changes of the scene are not seen. Safe to use from several
/// threads.
///
///   SceneQuery query(scene);
///   torch::Tensor depth = -query.signed_distance(joints.view({-1, 3}));
class SceneQuery {
 public:
  /// Throws Error when the scene has neither a face nor a point.
  explicit SceneQuery(const Scene& scene);
  ~SceneQuery();
  SceneQuery(SceneQuery&&) noexcept;             ///< what was moved from may only be destroyed
  SceneQuery& operator=(SceneQuery&&) noexcept;  ///< likewise

  /// What is nearest to `points` (N, 3): faces, and points of the cloud.
  ClosestPoints closest(const torch::Tensor& points) const;

  /// (N) metres to the nearest surface, negative inside; what is inside is said at Solid. Not differentiable.
  torch::Tensor signed_distance(const torch::Tensor& points) const;

  /// (N) bool. The winding numbers are counted along 24 fixed directions, fewer where the first six agree: exact in
  /// closed parts.
  torch::Tensor inside(const torch::Tensor& points) const;

  /// First hits from `origins` (N, 3) along `directions` (N, 3), which need not be of unit length.
  RayHits cast(const torch::Tensor& origins, const torch::Tensor& directions,
               double max_distance = std::numeric_limits<double>::infinity()) const;

  /// All triangles, and which side of them is outside.
  const Solid& solid() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The `count` points of `cloud` (M, 3) nearest to each of `points` (N, 3), nearest first.
struct Neighbours {
  torch::Tensor indices;    ///< (N, count) int64 into the cloud
  torch::Tensor distances;  ///< (N, count) metres
};

/// Nearest neighbours in a point cloud, by a k-d tree built once. Safe to use from several threads.
class CloudQuery {
 public:
  /// @param cloud (M, 3); throws Error when it is empty.
  explicit CloudQuery(const torch::Tensor& cloud);
  ~CloudQuery();
  CloudQuery(CloudQuery&&) noexcept;             ///< what was moved from may only be destroyed
  CloudQuery& operator=(CloudQuery&&) noexcept;  ///< likewise

  /// Throws Error when the cloud has fewer points than `count`.
  Neighbours nearest(const torch::Tensor& points, int64_t count = 1) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit
