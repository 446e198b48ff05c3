#include "inhabit/synth/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace inhabit {
namespace {

using Eigen::Vector2d;

constexpr double kCell = 0.1;          // metres
constexpr double kSpacing = 0.02;      // metres between points of a way
constexpr double kHeadHeight = 1.9;    // what is higher is walked under
constexpr double kStepHeight = 0.04;   // what is lower is walked over

WalkPath path_through(const std::vector<Vector2d>& points) {
  WalkPath path;
  double carried = 0;
  path.points.push_back(points.front());
  for (size_t i = 1; i < points.size(); ++i) {
    const Vector2d leg = points[i] - points[i - 1];
    const double length = leg.norm();
    for (double s = kSpacing - carried; s <= length; s += kSpacing) path.points.push_back(points[i - 1] + leg * (s / length));
    carried = std::fmod(carried + length, kSpacing);
  }
  path.length.resize(path.points.size());
  for (size_t i = 1; i < path.points.size(); ++i)
    path.length[i] = path.length[i - 1] + (path.points[i] - path.points[i - 1]).norm();
  return path;
}

}  // namespace

Vector2d ahead_of(double heading) { return {std::sin(heading), std::cos(heading)}; }
Vector2d left_of(double heading) { return {std::cos(heading), -std::sin(heading)}; }
double heading_of(const Vector2d& direction) { return std::atan2(direction.x(), direction.y()); }
double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

Vector2d WalkPath::at(double s) const {
  if (s <= 0) return points.front();
  if (s >= total()) return points.back();
  const auto after = static_cast<size_t>(std::upper_bound(length.begin(), length.end(), s) - length.begin());
  const double u = (s - length[after - 1]) / (length[after] - length[after - 1]);
  return points[after - 1] + u * (points[after] - points[after - 1]);
}

double WalkPath::heading(double s) const {
  s = std::clamp(s, 0.0, total());
  return heading_of(at(std::min(s + 0.06, total())) - at(std::max(s - 0.06, 0.0)));
}

FloorPlan::FloorPlan(const Room& room) : half_size_(room.size / 2) {
  auto add = [&](const Box& box, const Eigen::Isometry3d& pose) {
    const double low = box.center.y() - box.half.y() + pose.translation().y();
    if (low > kHeadHeight || low + 2 * box.half.y() < kStepHeight) return;
    const Eigen::Vector3d center = pose * box.center, axis = pose.linear().col(0);
    obstacles_.push_back(
        {{center.x(), center.z()}, Vector2d(axis.x(), axis.z()).normalized(), {box.half.x(), box.half.z()}});
  };
  for (const Box& wall : room.walls) add(wall, Eigen::Isometry3d::Identity());
  for (const Furniture& piece : room.furniture)
    for (const Box& box : piece.boxes) add(box, piece.pose);
  columns_ = std::max(1, static_cast<int>(std::ceil(room.size.x() / kCell)));
  rows_ = std::max(1, static_cast<int>(std::ceil(room.size.y() / kCell)));
  grid_.resize(static_cast<size_t>(columns_) * rows_);
  for (int cell = 0; cell < columns_ * rows_; ++cell) grid_[cell] = static_cast<float>(clearance(middle(cell)));
}

Vector2d FloorPlan::middle(int cell) const {
  return Vector2d((cell % columns_ + 0.5) * kCell, (cell / columns_ + 0.5) * kCell) - half_size_;
}

int FloorPlan::cell_at(const Vector2d& point) const {
  const Vector2d p = (point + half_size_) / kCell;
  const int column = std::clamp(static_cast<int>(std::floor(p.x())), 0, columns_ - 1);
  return std::clamp(static_cast<int>(std::floor(p.y())), 0, rows_ - 1) * columns_ + column;
}

bool FloorPlan::inside(const Vector2d& point) const {
  return std::abs(point.x()) < half_size_.x() && std::abs(point.y()) < half_size_.y();
}

double FloorPlan::clearance(const Vector2d& point) const {
  // Also where a wall has an opening nobody leaves the room.
  double nearest = (half_size_ - point.cwiseAbs()).minCoeff();
  for (const Obstacle& o : obstacles_) {
    const Vector2d d = point - o.center;
    // Own z on the floor is own x turned by a right angle.
    const Vector2d local(std::abs(d.dot(o.axis)), std::abs(-d.x() * o.axis.y() + d.y() * o.axis.x()));
    const Vector2d out = local - o.half;
    const double distance = out.cwiseMax(0).norm() + std::min(out.maxCoeff(), 0.0);
    nearest = std::min(nearest, distance);
  }
  return nearest;
}

void FloorPlan::smooth(std::vector<Vector2d>& points, double margin) const {
  std::vector<Vector2d> next;
  for (int round = 0; round < 60; ++round) {
    next = points;
    for (size_t i = 1; i + 1 < points.size(); ++i) {
      const Vector2d before = points[i > 1 ? i - 2 : 0], after = points[std::min(i + 2, points.size() - 1)];
      const Vector2d moved = 0.5 * points[i] + 0.125 * (before + after) + 0.125 * (points[i - 1] + points[i + 1]);
      if (grid_[cell_at(moved)] >= margin || clearance(moved) >= std::min(margin, clearance(points[i]))) next[i] = moved;
    }
    points.swap(next);
  }
}

std::optional<WalkPath> FloorPlan::way(const Vector2d& from, const Vector2d& to, double margin) const {
  if (!inside(from) || !inside(to)) return std::nullopt;
  // Whoever has just stood up, or wants to sit down, is nearer to furniture than a walker would be.
  const double hard = margin - 0.04;
  auto open = [&](int cell) {
    if (grid_[cell] >= hard) return true;
    const double near = std::min((middle(cell) - from).norm(), (middle(cell) - to).norm());
    return near < 0.45 && grid_[cell] > 0.1;
  };
  const int start = cell_at(from), goal = cell_at(to), cells = columns_ * rows_;
  std::vector<double> cost(cells, std::numeric_limits<double>::infinity());
  std::vector<int> parent(cells, -1);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  cost[start] = 0;
  queue.emplace((from - to).norm(), start);
  while (!queue.empty()) {
    const auto [estimate, cell] = queue.top();
    queue.pop();
    if (cell == goal) break;
    if (estimate > cost[cell] + (middle(cell) - to).norm() + 1e-6) continue;
    const int column = cell % columns_, row = cell / columns_;
    for (int dr = -1; dr <= 1; ++dr)
      for (int dc = -1; dc <= 1; ++dc) {
        const int c = column + dc, r = row + dr;
        if ((dr == 0 && dc == 0) || c < 0 || r < 0 || c >= columns_ || r >= rows_) continue;
        const int other = r * columns_ + c;
        if (!open(other) && other != goal) continue;
        const double tight = std::max(0.0, 0.55 - grid_[other]);
        const double step = kCell * std::sqrt(static_cast<double>(dr * dr + dc * dc)) * (1 + 6 * tight);
        if (cost[cell] + step >= cost[other]) continue;
        cost[other] = cost[cell] + step;
        parent[other] = cell;
        queue.emplace(cost[other] + (middle(other) - to).norm(), other);
      }
  }
  if (start != goal && parent[goal] < 0) return std::nullopt;
  std::vector<Vector2d> points{to};
  for (int cell = parent[goal]; cell >= 0 && cell != start; cell = parent[cell]) points.push_back(middle(cell));
  points.push_back(from);
  std::reverse(points.begin(), points.end());
  smooth(points, margin);
  return path_through(points);
}

}  // namespace inhabit
