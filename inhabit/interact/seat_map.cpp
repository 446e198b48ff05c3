#include "inhabit/interact/seat_map.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/quantile.h"
#include "inhabit/scene/query.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector2d;

constexpr double kUpright = 0.85;     // of a normal's height, at least, where one can sit
constexpr float kSameLevel = 0.025F;  // metres between neighbouring points of one area
constexpr int kGap = 3;               // points that a gap between slats is wide at most

/// Takes points of a gap as level, at the height of what is on both sides of it along an axis.
void bridge_gaps(TopView& view) {
  for (const bool along_x : {true, false}) {
    const int lines = along_x ? view.nz : view.nx, count = along_x ? view.nx : view.nz;
    const auto place = [&](int line, int i) { return along_x ? view.at(i, line) : view.at(line, i); };
    for (int line = 0; line < lines; ++line)
      for (int i = 0, last = -1; i < count; ++i) {
        const size_t here = place(line, i);
        if (view.level[here] == 0) continue;
        if (last >= 0 && i - last > 1 && i - last <= kGap + 1) {
          const float h = view.height[place(line, last)];
          bool open = std::abs(view.height[here] - h) < kSameLevel;
          for (int k = last + 1; k < i; ++k) open = open && view.height[place(line, k)] < h + kSameLevel;
          for (int k = last + 1; open && k < i; ++k) {
            view.height[place(line, k)] = h;
            view.level[place(line, k)] = 1;
          }
        }
        last = i;
      }
  }
}

/// Metres from each member to the nearest point that is none (chamfer distance, 5 % off at most).
double largest_disc(const TopView& view, const std::vector<int>& area_of, int area) {
  const size_t w = static_cast<size_t>(view.nx) + 2;
  std::vector<float> d(w * (static_cast<size_t>(view.nz) + 2), 0.F);
  const auto at = [&](int ix, int iz) { return (static_cast<size_t>(iz) + 1) * w + static_cast<size_t>(ix) + 1; };
  const auto lower = [&](size_t here, size_t there, float step) { d[here] = std::min(d[here], d[there] + step); };
  for (int iz = 0; iz < view.nz; ++iz)
    for (int ix = 0; ix < view.nx; ++ix) {
      if (area_of[view.at(ix, iz)] != area) continue;
      const size_t here = at(ix, iz);
      d[here] = 1e9F;
      lower(here, here - 1, 1);
      lower(here, here - w, 1);
      lower(here, here - w - 1, 1.414F);
      lower(here, here - w + 1, 1.414F);
    }
  float largest = 0;
  for (int iz = view.nz - 1; iz >= 0; --iz)
    for (int ix = view.nx - 1; ix >= 0; --ix) {
      const size_t here = at(ix, iz);
      if (area_of[view.at(ix, iz)] != area) continue;
      lower(here, here + 1, 1);
      lower(here, here + w, 1);
      lower(here, here + w + 1, 1.414F);
      lower(here, here + w - 1, 1.414F);
      largest = std::max(largest, d[here]);
    }
  return view.cell * static_cast<double>(largest);
}

/// The members of the area that a level point belongs to, all given its number.
std::vector<int> flood(const TopView& view, int start, int area, float low, float high, std::vector<int>& area_of) {
  std::vector<int> members{start};
  area_of[static_cast<size_t>(start)] = area;
  for (size_t next = 0; next < members.size(); ++next) {
    const int here = members[next], ix = here % view.nx, iz = here / view.nx;
    for (const auto& [dx, dz] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const int x = ix + dx, z = iz + dz;
      if (x < 0 || z < 0 || x >= view.nx || z >= view.nz) continue;
      const size_t there = view.at(x, z);
      const float h = view.height[there];
      if (area_of[there] >= 0 || view.level[there] == 0 || h < low || h > high) continue;
      if (std::abs(h - view.height[static_cast<size_t>(here)]) > kSameLevel) continue;
      area_of[there] = area;
      members.push_back(static_cast<int>(there));
    }
  }
  return members;
}

std::vector<Vector2d> convex_hull(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const Vector2d& a, const Vector2d& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  std::vector<Vector2d> hull;
  const auto leftwards = [](const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  };
  for (int side = 0; side < 2; ++side) {
    const size_t first = hull.size();
    for (const Vector2d& p : points) {
      while (hull.size() >= first + 2 && leftwards(hull[hull.size() - 2], hull.back(), p) <= 1e-9) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

}  // namespace

TopView view_from_above(const Mesh& mesh) {
  const torch::Tensor low = std::get<0>(mesh.vertices.min(0)), high = std::get<0>(mesh.vertices.max(0));
  const auto value = [](const torch::Tensor& t, int64_t i) { return t[i].item<double>(); };
  TopView view;
  view.floor = value(low, 1);
  const double width = value(high, 0) - value(low, 0), depth = value(high, 2) - value(low, 2), top = value(high, 1);
  if (!(std::max(width, depth) <= 10)) throw Error(mesh.name, "is too large to be a seat");
  view.nx = std::max(1, static_cast<int>(width / view.cell));
  view.nz = std::max(1, static_cast<int>(depth / view.cell));
  // Points stand off the edges by as much on both sides: none on a side itself.
  view.origin = {(value(low, 0) + value(high, 0) - view.cell * (view.nx - 1)) / 2,
                 (value(low, 2) + value(high, 2) - view.cell * (view.nz - 1)) / 2};
  const int64_t count = static_cast<int64_t>(view.nx) * view.nz;
  torch::Tensor from = torch::empty({count, 3}), down = torch::zeros({count, 3});
  down.select(1, 1).fill_(-1);
  float* p = from.data_ptr<float>();
  for (int iz = 0; iz < view.nz; ++iz)
    for (int ix = 0; ix < view.nx; ++ix, p += 3) {
      const Vector2d at = view.point(ix, iz);
      p[0] = static_cast<float>(at.x());
      p[1] = static_cast<float>(top + 0.1);
      p[2] = static_cast<float>(at.y());
    }
  Scene scene;
  scene.meshes = {mesh};
  const RayHits hits = SceneQuery(scene).cast(from, down);
  const auto hit = hits.hit.accessor<bool, 1>();
  const auto points = hits.points.accessor<float, 2>(), normals = hits.normals.accessor<float, 2>();
  view.height.assign(static_cast<size_t>(count), -1.F);
  view.level.assign(static_cast<size_t>(count), 0);
  for (int64_t i = 0; i < count; ++i) {
    if (!hit[i]) continue;
    view.height[static_cast<size_t>(i)] = points[i][1] - static_cast<float>(view.floor);
    view.level[static_cast<size_t>(i)] = std::abs(normals[i][1]) > static_cast<float>(kUpright);
  }
  return view;
}

std::vector<LevelArea> level_areas(const TopView& top_view, double low, double high) {
  TopView view = top_view;
  bridge_gaps(view);
  std::vector<int> area_of(view.height.size(), -1);
  std::vector<LevelArea> areas;
  int number = 0;
  for (size_t i = 0; i < area_of.size(); ++i) {
    if (area_of[i] >= 0 || view.level[i] == 0 || view.height[i] < static_cast<float>(low) ||
        view.height[i] > static_cast<float>(high))
      continue;
    const std::vector<int> members =
        flood(view, static_cast<int>(i), number, static_cast<float>(low), static_cast<float>(high), area_of);
    LevelArea area;
    area.inner_radius = members.size() < 30 ? 0 : largest_disc(view, area_of, number);
    std::vector<float> heights;
    for (const int m : members) {
      area.points.push_back(view.point(m % view.nx, m / view.nx));
      heights.push_back(view.height[static_cast<size_t>(m)]);
    }
    area.height = median(std::move(heights));
    areas.push_back(std::move(area));
    ++number;
  }
  std::stable_sort(areas.begin(), areas.end(),
                   [](const LevelArea& a, const LevelArea& b) { return a.inner_radius > b.inner_radius; });
  return areas;
}

double rectangle_heading(const std::vector<Vector2d>& points) {
  const std::vector<Vector2d> hull = convex_hull(points);
  double best = 0, smallest = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < hull.size(); ++i) {
    const Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
    if (edge.norm() < 1e-6) continue;
    const Vector2d along = edge.normalized(), across(-along.y(), along.x());
    double low_a = 1e9, high_a = -1e9, low_c = 1e9, high_c = -1e9;
    for (const Vector2d& p : hull) {
      low_a = std::min(low_a, p.dot(along));
      high_a = std::max(high_a, p.dot(along));
      low_c = std::min(low_c, p.dot(across));
      high_c = std::max(high_c, p.dot(across));
    }
    const double area = (high_a - low_a) * (high_c - low_c);
    if (area < smallest - 1e-9) {
      smallest = area;
      best = heading_of(along);
    }
  }
  return best;
}

}  // namespace inhabit::interact
