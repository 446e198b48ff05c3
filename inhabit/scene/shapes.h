#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// Collects closed shapes into one mesh.
class MeshBuilder {
 public:
  /// An axis-aligned box whose edges are rounded by `radius` in `steps` facets from side to edge; 0 leaves it sharp.
  /// It touches all six sides of the box and stays inside.
  void box(const Eigen::Vector3d& center, const Eigen::Vector3d& half, double radius = 0, int steps = 1);
  /// A prism around the vertical through (center.x, center.z) with `sides` sides, from y0 to y1 and radius r0 to r1.
  void column(const Eigen::Vector3d& center, double y0, double y1, double r0, double r1, int sides = 12);
  /// Whether nothing was added yet.
  bool empty() const { return faces_.empty(); }
  /// All that was added. @param color linear RGB, 0 to 1
  Mesh mesh(const std::string& name, const std::array<float, 3>& color) const;

 private:
  int64_t vertex(const Eigen::Vector3d& p);
  void quad(int64_t a, int64_t b, int64_t c, int64_t d);
  std::vector<float> vertices_;
  std::vector<int64_t> faces_;
};

}  // namespace inhabit
