#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace inhabit::reconstruct {

/// A pinhole camera and where it stands. Its axes are those of images: +X right, +Y down, +Z ahead. The point (x, y, z)
/// in them is seen at column fx x / z + cx and row fy y / z + cy; the middle of the first pixel is (0, 0).
struct Camera {
  double fx = 0;       ///< pixels, focal length along a row
  double fy = 0;       ///< pixels, focal length along a column
  double cx = 0;       ///< pixels, column of what is straight ahead
  double cy = 0;       ///< pixels, row of what is straight ahead
  int64_t width = 0;   ///< pixels of a row
  int64_t height = 0;  ///< pixels of a column
  /// Camera to the world that results are in, +Y up, metres: one for all frames or one for each.
  std::vector<Eigen::Isometry3d> to_world;
  /// The file's world to that world, a rotation that brings gravity down.
  Eigen::Quaterniond upright = Eigen::Quaterniond::Identity();
  bool motion_in_camera = false;  ///< the motion is in the axes of each frame's camera

  /// Whether there is a pose for each frame.
  bool moves() const { return to_world.size() > 1; }
  /// Camera to world in a frame: the one pose that there is, where it does not move.
  const Eigen::Isometry3d& pose(int64_t frame) const { return to_world[moves() ? static_cast<size_t>(frame) : 0]; }
  /// Direction in the camera's axes with z = 1 of what is seen at a column and row.
  Eigen::Vector3d ray(double column, double row) const { return {(column - cx) / fx, (row - cy) / fy, 1}; }
};

/// A camera file, JSON (docs/reconstruction.md): fx, fy, cx, cy, width, height; `camera_to_world` or `world_to_camera`,
/// a matrix of 3 or 4 rows of 4 numbers or a list of one a frame (without either the world is the camera's own axes);
/// `gravity`, a direction in the world, down; `motion`, "world" or "camera". Throws Error(path, ...) naming the key
/// that is missing or no such thing.
Camera read_camera(const std::string& path);

/// The same from memory; `subject` names the source in errors.
Camera parse_camera(std::string_view text, const std::string& subject);

/// The text of such a file.
std::string camera_json(const Camera& camera);

}  // namespace inhabit::reconstruct
