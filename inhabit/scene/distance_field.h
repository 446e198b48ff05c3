#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <optional>

#include "inhabit/scene/query.h"

namespace inhabit {

/// The signed distance to a scene's surfaces at the corners of a grid, interpolated between them: for who asks millions
/// of times, or needs a gradient. Metres, world, negative inside (see Solid). Exact at corners; a plane that no other
/// surface is near comes out exact everywhere, an edge or a thin board is rounded over one cell. Corners are sampled
/// when they are first needed, 512 cells at a time, two milliseconds each. Safe to use from several threads.
///
///   const SceneQuery query(scene);
///   const DistanceField field(query, box_around_the_motion);
///   Eigen::Vector3d uphill;
///   const double outside_by = field.distance(point, &uphill);
class DistanceField {
 public:
  /// @param query must outlive this. @param box what the grid covers, grown to whole cells; @param cell edge of a cell,
  /// metres. Throws Error when the box is empty or not finite, the cell is no length, or there are more than 2^27
  /// cells.
  DistanceField(const SceneQuery& query, const Eigen::AlignedBox3d& box, double cell = 0.05);
  ~DistanceField();
  DistanceField(DistanceField&&) noexcept;             ///< what was moved from may only be destroyed
  DistanceField& operator=(DistanceField&&) noexcept;  ///< likewise

  /// Trilinear distance. Beyond the grid: the value at the nearest point of the grid plus the distance from there.
  /// Throws Error when the point is not finite.
  /// @param gradient where not null, that of what is returned (metres a metre; it jumps from cell to cell).
  double distance(const Eigen::Vector3d& point, Eigen::Vector3d* gradient = nullptr) const;

  /// Whether `point` is inside, where that is certain: no surface lies between it and the corners around that tell. A
  /// surface may be as near as that to a corner's own distance, or to `clear`: metres around `point` that are known to
  /// hold none. Nothing where no corner tells, beyond the grid, or where corners disagree, as they do at the rim of an
  /// open shell.
  std::optional<bool> inside(const Eigen::Vector3f& point, float clear = 0) const;

  /// Metres that are free of surfaces around `point` at least; 0 beyond the grid.
  float clearance(const Eigen::Vector3f& point) const;

  /// Samples the corners in a box at once, in place of when they are first needed, for who must not wait then.
  /// @param stopped is asked before every 512 cells whether to leave off; may be empty
  void sample(const Eigen::AlignedBox3d& box, const std::function<bool()>& stopped = {}) const;

  /// Metres, as it was made with.
  double cell() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit
