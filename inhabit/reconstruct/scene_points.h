#pragma once
#include <torch/types.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "inhabit/reconstruct/depth_map.h"
#include "inhabit/scene/scene.h"

namespace inhabit::reconstruct {

/// Points of many depth maps in cells of a grid: each cell keeps the mean of what fell into it, so that memory grows
/// with the surface that was seen and not with the number of frames.
class PointGrid {
 public:
  /// @param cell metres, side of a cell.
  explicit PointGrid(double cell) : cell_(cell) {}

  /// Adds the pixels of `where` (height, width) bool whose depth is known. Throws Error(subject, ...) where the scene
  /// grows beyond all measure (8 million cells): a scale that cannot be.
  void add(const View& view, const torch::Tensor& where, const Camera& camera, const std::string& subject);

  /// The mean points of cells that at least `frames` frames fell into.
  std::vector<Eigen::Vector3d> points(int64_t frames) const;

 private:
  struct Cell {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int64_t count = 0, frames = 0, last = -1;
  };
  struct Hash {
    size_t operator()(const std::array<int64_t, 3>& key) const;
  };
  double cell_;
  std::unordered_map<std::array<int64_t, 3>, Cell, Hash> cells_;
};

/// The points without those that the camera has seen through: two views or more (one where there is only one) look at
/// something more than `margin` (metres, and as a part of the distance) behind them in the same direction. What a mask
/// missed of a person who walks by is so taken away.
std::vector<Eigen::Vector3d> without_seen_through(const std::vector<Eigen::Vector3d>& points,
                                                  const std::vector<View>& views, const Camera& camera, double margin);

/// Height of the floor, metres: the middle of the fullest layer of points within `reach` of `expected`; `expected`
/// where fewer than 50 are there. @param points of the scene, +Y up
double floor_height(const std::vector<Eigen::Vector3d>& points, double expected, double reach);

/// A flat mesh called "floor" at `height` under all of the points, one metre farther to every side.
Mesh floor_mesh(const std::vector<Eigen::Vector3d>& points, double height);

}  // namespace inhabit::reconstruct
