#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <vector>

namespace inhabit {

/// Triangles while a surface is being made. Counter-clockwise seen from outside.
struct TriangleSurface {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> faces;
};

/// Signed distance, metres, negative inside.
using SurfaceDistance = std::function<double(const Eigen::Vector3d&)>;

/// The zero surface of a field in a box, by marching tetrahedra on a grid: every edge inside the box is shared by
/// exactly two faces. Where the surface leaves the box it is open, with its edge exactly in the box's side.
/// @param cell edge of a grid cell, metres; @param low,high corners of the box (high is rounded up to whole cells).
TriangleSurface polygonise(const SurfaceDistance& field, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                           double cell);

/// Each vertex goes half way to the mean of its neighbours, `rounds` times: takes away the slivers that marching
/// leaves. Vertices in the plane x = 0 stay in it.
void smooth(TriangleSurface& surface, int rounds);

/// The same in each vertex's tangent plane, then onto the field's zero surface along its gradient.
void relax(const SurfaceDistance& field, TriangleSurface& surface, int rounds);

/// Both halves of a surface whose open edge lies in the plane x = 0.
TriangleSurface mirrored(const TriangleSurface& half);

}  // namespace inhabit
