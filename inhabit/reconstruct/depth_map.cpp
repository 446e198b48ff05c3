#include "inhabit/reconstruct/depth_map.h"

#include <cmath>

#include "inhabit/error.h"

namespace inhabit::reconstruct {
namespace {

using torch::Tensor;

/// The largest value in a square of 2 pixels + 1 around each.
Tensor largest_around(const Tensor& mask, int pixels) {
  const int64_t side = 2 * pixels + 1;
  return torch::max_pool2d(mask.to(torch::kFloat32).unsqueeze(0), {side, side}, {1, 1}, {pixels, pixels})[0];
}

}  // namespace

DepthMap combined(const Tensor& maps, double uncertainty) {
  const Tensor known = maps.ne(0).all(0);
  DepthMap out{maps.mean(0), known};
  if (maps.size(0) == 1 || !known.any().item<bool>()) return out;
  const Tensor depths = out.raw.index({known});
  const double middle = depths.median().item<double>();
  const double spread = 1.4826 * (depths - middle).abs().median().item<double>();
  out.sure = known.logical_and(maps.std(0, true).le(uncertainty * spread));
  return out;
}

Tensor metric_depth(const DepthMap& map, const DepthScale& scale, double jump) {
  const Tensor depth = map.raw * scale.scale + scale.offset;
  Tensor good = map.sure.logical_and(depth.gt(0.05));
  for (int64_t axis = 0; axis < 2; ++axis) {
    const int64_t n = depth.size(axis);
    const Tensor before = depth.narrow(axis, 0, n - 1), after = depth.narrow(axis, 1, n - 1);
    const Tensor jumps = (before - after).abs().gt(jump * torch::minimum(before, after));
    good.narrow(axis, 0, n - 1).logical_and_(jumps.logical_not());
    good.narrow(axis, 1, n - 1).logical_and_(jumps.logical_not());
  }
  return torch::where(good, depth, torch::zeros_like(depth)).contiguous();
}

Tensor eroded(const Tensor& mask, int pixels) { return largest_around(mask.logical_not(), pixels).lt(0.5); }

Tensor dilated(const Tensor& mask, int pixels) { return largest_around(mask, pixels).gt(0.5); }

std::vector<DepthSample> samples_of(const Tensor& depth, const Tensor& where, const Camera& camera, int64_t most) {
  const Tensor pixels = where.nonzero();  // (N, 2) row, column
  const auto p = pixels.accessor<int64_t, 2>();
  const auto d = depth.accessor<float, 2>();
  const int64_t all = pixels.size(0), count = std::min(all, most);
  std::vector<DepthSample> out;
  out.reserve(static_cast<size_t>(count));
  for (int64_t i = 0; i < count; ++i) {
    const int64_t k = i * all / count, row = p[k][0], column = p[k][1];
    out.push_back({camera.ray(static_cast<double>(column), static_cast<double>(row)), d[row][column]});
  }
  return out;
}

std::vector<Eigen::Vector3d> back_projected(const std::vector<DepthSample>& samples,
                                            const Eigen::Isometry3d& to_world) {
  std::vector<Eigen::Vector3d> out;
  out.reserve(samples.size());
  for (const DepthSample& s : samples) out.push_back(to_world * Eigen::Vector3d(s.depth * s.ray));
  return out;
}

OnImage project(const Camera& camera, const Eigen::Isometry3d& to_camera, const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = to_camera * point;
  OnImage out;
  out.z = p.z();
  if (!(p.z() > 0.05)) return out;
  const double column = std::round(camera.fx * p.x() / p.z() + camera.cx),
               row = std::round(camera.fy * p.y() / p.z() + camera.cy);
  if (!(column >= 0 && row >= 0 && column < static_cast<double>(camera.width) &&
        row < static_cast<double>(camera.height)))
    return out;
  out.column = static_cast<int64_t>(column);
  out.row = static_cast<int64_t>(row);
  return out;
}

}  // namespace inhabit::reconstruct
