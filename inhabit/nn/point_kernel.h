#pragma once
#include <cstdint>
#include <vector>

namespace inhabit::nn {

/// Positions by axis, padded with far-away points to a multiple of 16: what the loops over all points read.
struct PointArrays {
  PointArrays() = default;
  /// @param points (count, 3).
  PointArrays(const float* points, int64_t count);

  int64_t count = 0, padded = 0;
  std::vector<float> x, y, z;
};

/// `chosen` indices each furthest from those before, the first of equals, starting with 0.
void furthest_points_of_cloud(const PointArrays& cloud, int64_t count, int64_t* chosen);

/// First `wanted` points, in order, closer than sqrt(squared_radius) to the centre. Returns how many were found.
int64_t points_in_ball(const PointArrays& cloud, const float* centre, float squared_radius, int64_t wanted,
                       int64_t* found);

/// The three nearest points, nearest first, the first of equals; fewer than three leave infinity behind.
void three_nearest_points(const PointArrays& cloud, const float* point, float squared_distance[3], int64_t index[3]);

}  // namespace inhabit::nn
