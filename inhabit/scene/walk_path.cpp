#include "inhabit/scene/walk_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace inhabit {
namespace {

using Eigen::Vector2d;

constexpr double kSpacing = 0.02;  // metres between points of a path

WalkPath path_through(const std::vector<Vector2d>& points) {
  WalkPath path;
  double carried = 0;
  path.points.push_back(points.front());
  for (size_t i = 1; i < points.size(); ++i) {
    const Vector2d leg = points[i] - points[i - 1];
    const double length = leg.norm();
    for (double s = kSpacing - carried; s <= length; s += kSpacing)
      path.points.push_back(points[i - 1] + leg * (s / length));
    carried = std::fmod(carried + length, kSpacing);
  }
  path.length.resize(path.points.size());
  for (size_t i = 1; i < path.points.size(); ++i)
    path.length[i] = path.length[i - 1] + (path.points[i] - path.points[i - 1]).norm();
  return path;
}

void smooth(std::vector<Vector2d>& points, const FreeSpace& floor, double margin) {
  std::vector<Vector2d> next;
  for (int round = 0; round < 60; ++round) {
    next = points;
    for (size_t i = 1; i + 1 < points.size(); ++i) {
      const Vector2d before = points[i > 1 ? i - 2 : 0], after = points[std::min(i + 2, points.size() - 1)];
      const Vector2d moved = 0.5 * points[i] + 0.125 * (before + after) + 0.125 * (points[i - 1] + points[i + 1]);
      const double clear = floor.at(moved);
      if (clear >= margin || clear >= floor.at(points[i])) next[i] = moved;
    }
    points.swap(next);
  }
}

}  // namespace

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

std::optional<WalkPath> find_path(const FreeSpace& floor, const Vector2d& from, const Vector2d& to, double margin) {
  // Every other point of the grid will do.
  const int columns = (floor.nx + 1) / 2, rows = (floor.nz + 1) / 2, cells = columns * rows;
  auto middle = [&](int cell) { return floor.point(2 * (cell % columns), 2 * (cell / columns)); };
  auto clear = [&](int cell) {
    return floor.clearance[static_cast<size_t>(2 * (cell / columns)) * floor.nx + 2 * (cell % columns)];
  };
  auto nearest = [&](const Vector2d& p) {
    const Vector2d q = (p - floor.origin) / (2 * floor.cell);
    const int column = std::clamp(static_cast<int>(std::lround(q.x())), 0, columns - 1);
    return std::clamp(static_cast<int>(std::lround(q.y())), 0, rows - 1) * columns + column;
  };
  // Whoever has just stood up, or wants to sit down, is nearer to furniture than a walker would be.
  auto open = [&](int cell) {
    if (clear(cell) >= margin - 0.04) return true;
    const double near = std::min((middle(cell) - from).norm(), (middle(cell) - to).norm());
    return near < 0.45 && clear(cell) > 0.1;
  };
  const int start = nearest(from), goal = nearest(to);
  std::vector<double> cost(cells, std::numeric_limits<double>::infinity());
  std::vector<int> parent(cells, -1);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  cost[start] = 0;
  queue.emplace((middle(start) - to).norm(), start);
  while (!queue.empty()) {
    const auto [estimate, cell] = queue.top();
    queue.pop();
    if (cell == goal) break;
    if (estimate > cost[cell] + (middle(cell) - to).norm() + 1e-6) continue;
    for (int dr = -1; dr <= 1; ++dr)
      for (int dc = -1; dc <= 1; ++dc) {
        const int c = cell % columns + dc, r = cell / columns + dr;
        if ((dr == 0 && dc == 0) || c < 0 || r < 0 || c >= columns || r >= rows) continue;
        const int other = r * columns + c;
        if (!open(other) && other != goal) continue;
        const double tight = std::max(0.0, 0.55 - clear(other));
        const double step = 2 * floor.cell * std::sqrt(static_cast<double>(dr * dr + dc * dc)) *
                            (1 + 6 * tight + (clear(other) < 0.24 ? 8 : 0));
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
  smooth(points, floor, margin);
  return path_through(points);
}

std::optional<WalkPath> find_roomy_path(const FreeSpace& floor, const Vector2d& from, const Vector2d& to,
                                        const std::vector<double>& margins, const LongerPath& longer) {
  std::vector<WalkPath> paths;
  for (const double margin : margins)
    if (auto path = find_path(floor, from, to, margin)) paths.push_back(std::move(*path));
  double shortest = std::numeric_limits<double>::infinity();
  for (const WalkPath& path : paths) shortest = std::min(shortest, path.total());
  for (WalkPath& path : paths)
    if (path.total() <= std::min(longer.longest, longer.times * shortest + longer.more)) return std::move(path);
  return std::nullopt;
}

}  // namespace inhabit
