#include "inhabit/scene/distance_field.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"

namespace inhabit {
namespace {

constexpr double kMostCorners = 1 << 27;
constexpr float kRounding = 1e-5F;  // metres that floats are off at most, a hundred metres from the origin

}  // namespace

DistanceField::DistanceField(const SceneQuery& query, const Eigen::AlignedBox3d& box, double cell) : cell_(cell) {
  if (!(cell > 0) || !std::isfinite(cell)) throw Error("distance field", "its cells have no length");
  if (!box.min().allFinite() || !box.max().allFinite() || (box.min().array() > box.max().array()).any())
    throw Error("distance field", "its box is empty or not finite");
  const Eigen::Vector3d cells = ((box.max() - box.min()) / cell).array().ceil().max(1.0);
  if ((cells.array() + 1).prod() > kMostCorners)
    throw Error("distance field", "its box of " + std::to_string(cells.maxCoeff() * cell) + " m has too many cells");
  corners_ = cells.cast<int>().array() + 1;
  origin_ = 0.5 * (box.min() + box.max()) - 0.5 * cell * cells;
  samples_.resize(static_cast<size_t>(corners_.x()) * static_cast<size_t>(corners_.y()) *
                  static_cast<size_t>(corners_.z()));
  // A few layers at a time: the query answers more than is kept.
  const int64_t layer = static_cast<int64_t>(corners_.x()) * corners_.y();
  const int together = static_cast<int>(std::max<int64_t>(1, (int64_t{1} << 18) / layer));
  for (int first = 0; first < corners_.z(); first += together) {
    const int last = std::min(first + together, corners_.z());
    torch::Tensor points = torch::empty({layer * (last - first), 3});
    float* p = points.data_ptr<float>();
    for (int z = first; z < last; ++z)
      for (int y = 0; y < corners_.y(); ++y)
        for (int x = 0; x < corners_.x(); ++x, p += 3)
          Eigen::Map<Eigen::Vector3f>(p, 3) = (origin_ + cell * Eigen::Vector3d(x, y, z)).cast<float>();
    const torch::Tensor distances = query.signed_distance(points);
    std::copy_n(distances.data_ptr<float>(), distances.numel(), samples_.begin() + layer * first);
  }
}

double DistanceField::distance(const Eigen::Vector3d& point, Eigen::Vector3d* gradient) const {
  if (!point.allFinite()) throw Error("distance field", "is asked about a point that is not finite");
  const Eigen::Vector3d wanted = (point - origin_) / cell_, last = (corners_.array() - 1).cast<double>();
  const Eigen::Vector3d at = wanted.cwiseMax(0.0).cwiseMin(last);
  const Eigen::Vector3i low = at.cast<int>().cwiseMin(corners_.array().matrix() - Eigen::Vector3i::Constant(2));
  const Eigen::Vector3d f = at - low.cast<double>();
  double v[2][2][2];  // z, y, x
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 2; ++x)
        v[z][y][x] = static_cast<double>(samples_[corner(low.x() + x, low.y() + y, low.z() + z)]);
  double along_x[2][2], along_y[2];
  for (int z = 0; z < 2; ++z) {
    for (int y = 0; y < 2; ++y) along_x[z][y] = v[z][y][0] + f.x() * (v[z][y][1] - v[z][y][0]);
    along_y[z] = along_x[z][0] + f.y() * (along_x[z][1] - along_x[z][0]);
  }
  const Eigen::Vector3d beyond = cell_ * (wanted - at);
  const double way = beyond.norm();
  if (gradient != nullptr) {
    const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
    const Eigen::Vector3d slope =
        Eigen::Vector3d(mix(mix(v[0][0][1] - v[0][0][0], v[0][1][1] - v[0][1][0], f.y()),
                            mix(v[1][0][1] - v[1][0][0], v[1][1][1] - v[1][1][0], f.y()), f.z()),
                        mix(along_x[0][1] - along_x[0][0], along_x[1][1] - along_x[1][0], f.z()),
                        along_y[1] - along_y[0]) /
        cell_;
    // Beyond a side only what lies along that side still changes the value inside.
    *gradient = (beyond.array() == 0).select(slope, way > 0 ? Eigen::Vector3d(beyond / way) : Eigen::Vector3d::Zero());
  }
  return along_y[0] + f.z() * (along_y[1] - along_y[0]) + way;
}

std::optional<bool> DistanceField::inside(const Eigen::Vector3f& point, float clear) const {
  const Eigen::Vector3f at = (point.cast<double>() - origin_).cast<float>(), cells = at / static_cast<float>(cell_);
  if (!(cells.array() >= 0).all() || !(cells.array() < (corners_.array() - 1).cast<float>()).all()) return {};
  const Eigen::Vector3i low = cells.cast<int>();
  int outside = 0, in = 0;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3i c = low + Eigen::Vector3i(k & 1, k >> 1 & 1, k >> 2);
    const float sample = samples_[corner(c.x(), c.y(), c.z())];
    const float reach = std::max(std::abs(sample), clear) - kRounding;
    if (reach <= 0 || (at - static_cast<float>(cell_) * c.cast<float>()).squaredNorm() >= reach * reach) continue;
    (sample < 0 ? in : outside) += 1;
  }
  if ((in > 0) == (outside > 0)) return {};
  return in > 0;
}

float DistanceField::clearance(const Eigen::Vector3f& point) const {
  const Eigen::Vector3f at = (point.cast<double>() - origin_).cast<float>(), cells = at / static_cast<float>(cell_);
  if (!(cells.array() >= 0).all() || !(cells.array() <= (corners_.array() - 1).cast<float>()).all()) return 0;
  const Eigen::Vector3i c = (cells.array() + 0.5F).cast<int>();
  const float way = (at - static_cast<float>(cell_) * c.cast<float>()).norm();
  return std::max(0.F, std::abs(samples_[corner(c.x(), c.y(), c.z())]) - way - kRounding);
}

}  // namespace inhabit
