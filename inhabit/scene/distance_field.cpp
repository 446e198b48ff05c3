#include "inhabit/scene/distance_field.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "inhabit/error.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr double kMostCells = 1 << 27;
constexpr int kEdge = 8;             // cells along a brick
constexpr int kCorners = kEdge + 1;  // samples along a brick; neighbours have those of their common side both
constexpr float kRounding = 1e-5F;   // metres that floats are off at most, a hundred metres from the origin
using Samples = std::array<float, kCorners * kCorners * kCorners>;

}  // namespace

struct DistanceField::Impl {
  const SceneQuery* query;
  double cell;
  Vector3d origin;  ///< world, of the grid's lowest corner
  Vector3i bricks, cells;
  /// A brick: which side of the scene all of it is on, where no surface and no rim comes near it.
  enum class Side : int8_t { mixed, outside, inside };
  std::vector<Side> sides;
  mutable std::unique_ptr<std::atomic<const Samples*>[]> samples;

  ~Impl() {
    if (samples == nullptr) return;  // the constructor threw before them
    for (size_t b = 0; b < sides.size(); ++b) delete samples[b].load();
  }

  size_t index(const Vector3i& brick) const {
    return (static_cast<size_t>(brick.z()) * static_cast<size_t>(bricks.y()) + static_cast<size_t>(brick.y())) *
               static_cast<size_t>(bricks.x()) +
           static_cast<size_t>(brick.x());
  }

  /// Signed distances at origin + step * (i + shift), i in [0, count) along each axis, x fastest.
  torch::Tensor sampled(const Vector3d& from, double step, const Vector3i& count) const {
    torch::Tensor points = torch::empty({static_cast<int64_t>(count.x()) * count.y() * count.z(), 3});
    float* p = points.data_ptr<float>();
    for (int z = 0; z < count.z(); ++z)
      for (int y = 0; y < count.y(); ++y)
        for (int x = 0; x < count.x(); ++x, p += 3)
          Eigen::Map<Vector3f>(p, 3) = (from + step * Vector3d(x, y, z)).cast<float>();
    return query->signed_distance(points);
  }

  /// Bricks whose middle is farther from surfaces than their corners are from it; corners and middle agree, so that no
  /// rim of an open shell passes through.
  void find_sides() {
    const double edge = kEdge * cell;
    const float reach = static_cast<float>(std::sqrt(0.75) * edge) + kRounding;
    const torch::Tensor middles = sampled(origin + Vector3d::Constant(edge / 2), edge, bricks),
                        corners = sampled(origin, edge, bricks.array() + 1);
    const float *m = middles.data_ptr<float>(), *c = corners.data_ptr<float>();
    const int64_t row = bricks.x() + 1, layer = row * (bricks.y() + 1);
    sides.assign(static_cast<size_t>(middles.numel()), Side::mixed);
    for (int z = 0; z < bricks.z(); ++z)
      for (int y = 0; y < bricks.y(); ++y)
        for (int x = 0; x < bricks.x(); ++x) {
          const size_t b = index({x, y, z});
          if (std::abs(m[b]) <= reach) continue;
          int below = 0;
          for (int k = 0; k < 8; ++k) below += c[(z + (k >> 2)) * layer + (y + (k >> 1 & 1)) * row + x + (k & 1)] < 0;
          if (below == (m[b] < 0 ? 8 : 0)) sides[b] = m[b] < 0 ? Side::inside : Side::outside;
        }
  }

  /// The samples of a brick; of threads that need them at the same time the first to have them wins.
  const Samples& of_brick(const Vector3i& brick) const {
    std::atomic<const Samples*>& place = samples[index(brick)];
    if (const Samples* there = place.load(std::memory_order_acquire)) return *there;
    auto made = std::make_unique<Samples>();
    const torch::Tensor distances =
        sampled(origin + cell * kEdge * brick.cast<double>(), cell, Vector3i::Constant(kCorners));
    std::copy_n(distances.data_ptr<float>(), made->size(), made->begin());
    const Samples* expected = nullptr;
    if (place.compare_exchange_strong(expected, made.get(), std::memory_order_acq_rel)) return *made.release();
    return *expected;
  }

  /// `at` in cells from the origin; nothing beyond the grid.
  struct Place {
    Vector3f at;  ///< cells within the brick
    Vector3i brick;
  };
  std::optional<Place> place_of(const Vector3f& point) const {
    const Vector3f at = ((point.cast<double>() - origin) / cell).cast<float>();
    if (!(at.array() >= 0).all() || !(at.array() < cells.cast<float>().array()).all()) return {};
    const Vector3i brick = at.cast<int>() / kEdge;
    return Place{at - static_cast<float>(kEdge) * brick.cast<float>(), brick};
  }
};

namespace {

size_t corner(int x, int y, int z) {
  constexpr auto kRow = static_cast<size_t>(kCorners);
  return (static_cast<size_t>(z) * kRow + static_cast<size_t>(y)) * kRow + static_cast<size_t>(x);
}

}  // namespace

DistanceField::DistanceField(const SceneQuery& query, const Eigen::AlignedBox3d& box, double cell)
    : impl_(std::make_unique<Impl>()) {
  if (!(cell > 0) || !std::isfinite(cell)) throw Error("distance field", "its cells have no length");
  if (!box.min().allFinite() || !box.max().allFinite() || (box.min().array() > box.max().array()).any())
    throw Error("distance field", "its box is empty or not finite");
  const Vector3d bricks = ((box.max() - box.min()) / (kEdge * cell)).array().ceil().max(1.0);
  if (bricks.prod() * kEdge * kEdge * kEdge > kMostCells)
    throw Error("distance field", "a box of " + std::to_string(box.sizes().maxCoeff()) + " m has too many cells");
  impl_->query = &query;
  impl_->cell = cell;
  impl_->bricks = bricks.cast<int>();
  impl_->cells = impl_->bricks * kEdge;
  impl_->origin = box.center() - 0.5 * kEdge * cell * bricks;
  impl_->find_sides();
  impl_->samples = std::make_unique<std::atomic<const Samples*>[]>(impl_->sides.size());
}

DistanceField::~DistanceField() = default;
DistanceField::DistanceField(DistanceField&&) noexcept = default;
DistanceField& DistanceField::operator=(DistanceField&&) noexcept = default;

double DistanceField::cell() const { return impl_->cell; }

void DistanceField::sample(const Eigen::AlignedBox3d& box, const std::function<bool()>& stopped) const {
  const auto brick_at = [&](const Vector3d& p) -> Vector3i {
    const Vector3d at = ((p - impl_->origin) / (kEdge * impl_->cell)).array().floor();
    return at.cwiseMax(0.0).cwiseMin((impl_->bricks.array() - 1).cast<double>().matrix()).cast<int>();
  };
  if (box.isEmpty()) return;
  const Vector3i first = brick_at(box.min()), last = brick_at(box.max());
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); ++x) {
        if (stopped && stopped()) return;
        impl_->of_brick({x, y, z});
      }
}

double DistanceField::distance(const Vector3d& point, Vector3d* gradient) const {
  if (!point.allFinite()) throw Error("distance field", "is asked about a point that is not finite");
  const Vector3d wanted = (point - impl_->origin) / impl_->cell;
  const Vector3d at = wanted.cwiseMax(0.0).cwiseMin(impl_->cells.cast<double>());
  const Vector3i low = at.cast<int>().cwiseMin((impl_->cells.array() - 1).matrix()), brick = low / kEdge;
  const Vector3d f = at - low.cast<double>();
  const Samples& samples = impl_->of_brick(brick);
  const Vector3i in = low - kEdge * brick;
  double v[2][2][2];  // z, y, x
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 2; ++x) v[z][y][x] = static_cast<double>(samples[corner(in.x() + x, in.y() + y, in.z() + z)]);
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  double along_x[2][2], along_y[2];
  for (int z = 0; z < 2; ++z) {
    for (int y = 0; y < 2; ++y) along_x[z][y] = mix(v[z][y][0], v[z][y][1], f.x());
    along_y[z] = mix(along_x[z][0], along_x[z][1], f.y());
  }
  const Vector3d beyond = impl_->cell * (wanted - at);
  const double apart = beyond.norm();
  if (gradient != nullptr) {
    const Vector3d slope =
        Vector3d(mix(mix(v[0][0][1] - v[0][0][0], v[0][1][1] - v[0][1][0], f.y()),
                     mix(v[1][0][1] - v[1][0][0], v[1][1][1] - v[1][1][0], f.y()), f.z()),
                 mix(along_x[0][1] - along_x[0][0], along_x[1][1] - along_x[1][0], f.z()), along_y[1] - along_y[0]) /
        impl_->cell;
    // Beyond a side only what lies along that side still changes the value inside.
    *gradient = (beyond.array() == 0).select(slope, apart > 0 ? Vector3d(beyond / apart) : Vector3d::Zero());
  }
  return mix(along_y[0], along_y[1], f.z()) + apart;
}

std::optional<bool> DistanceField::inside(const Vector3f& point, float clear) const {
  const auto place = impl_->place_of(point);
  if (!place) return {};
  const Impl::Side side = impl_->sides[impl_->index(place->brick)];
  if (side != Impl::Side::mixed) return side == Impl::Side::inside;
  const Samples& samples = impl_->of_brick(place->brick);
  const Vector3i low = place->at.cast<int>();
  const auto cell = static_cast<float>(impl_->cell);
  int outside = 0, in = 0;
  for (int k = 0; k < 8; ++k) {
    const Vector3i c = low + Vector3i(k & 1, k >> 1 & 1, k >> 2);
    const float sample = samples[corner(c.x(), c.y(), c.z())];
    const float reach = std::max(std::abs(sample), clear) - kRounding;
    if (reach <= 0 || cell * cell * (place->at - c.cast<float>()).squaredNorm() >= reach * reach) continue;
    (sample < 0 ? in : outside) += 1;
  }
  if ((in > 0) == (outside > 0)) return {};
  return in > 0;
}

float DistanceField::clearance(const Vector3f& point) const {
  const auto place = impl_->place_of(point);
  if (!place) return 0;
  const Vector3i c = (place->at.array() + 0.5F).cast<int>();
  const float apart = static_cast<float>(impl_->cell) * (place->at - c.cast<float>()).norm();
  return std::max(0.F, std::abs(impl_->of_brick(place->brick)[corner(c.x(), c.y(), c.z())]) - apart - kRounding);
}

}  // namespace inhabit
