#include "inhabit/interact/chair.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "inhabit/error.h"
#include "inhabit/interact/seat_map.h"
#include "inhabit/interact/seated.h"
#include "inhabit/lower_case.h"
#include "inhabit/math/heading.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/query.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSeatRadius = 0.14;  // of a disc that fits into a seat of 0.3 x 0.3 m, less half a grid cell
constexpr double kTaller = 0.12;      // metres over the seat: arm rests, back rests, legs in the air
constexpr double kFront = 0.26, kMargin = 0.13;  // of a pelvis at rest: behind the front edge, off all edges

/// What people do not sit on by themselves though they could: coffee tables are as high as chairs.
bool is_named_otherwise(const std::string& name) {
  constexpr std::array kOthers = {"table", "desk", "counter", "shelf", "cabinet", "drawer", "dresser", "stand"};
  const std::string lower = lower_case(name);
  return std::any_of(kOthers.begin(), kOthers.end(),
                     [&](const char* other) { return lower.find(other) != std::string::npos; });
}

Mesh object_mesh(const Scene& scene, const std::string& name) {
  Scene object;
  object.name = name;
  for (const Mesh& mesh : scene.meshes)
    if (object_of_mesh(mesh.name) == name && mesh.faces.numel() > 0) object.meshes.push_back(mesh);
  return merged_mesh(object);
}

Eigen::Isometry3d seat_frame(const Vector2d& place, double floor, double heading) {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = Eigen::AngleAxisd(heading, Vector3d::UnitY()).toRotationMatrix();
  frame.translation() = Vector3d(place.x(), floor, place.y());
  return frame;
}

/// Metres that are free from a seat outwards along a heading, 2.5 at most: where nothing but the seat's own object is
/// within 0.2 m of points from shin to breast.
double free_ahead(const Scene& scene, const std::string& without, const Vector3d& seat, double heading) {
  constexpr double kFarthest = 2.5, kStep = 0.1;
  const Scene others = obstacles_of(scene, without);
  if (others.meshes.empty()) return kFarthest;
  const Vector2d ahead = ahead_of(heading);
  std::vector<float> points;
  for (double d = 0.3; d < kFarthest; d += kStep)
    for (const double height : {-0.2, 0.15, 0.5})
      for (const double at : {seat.x() + d * ahead.x(), seat.y() + height, seat.z() + d * ahead.y()})
        points.push_back(static_cast<float>(at));
  const torch::Tensor near = SceneQuery(others).closest(torch::tensor(points).view({-1, 3})).distances.view({-1, 3});
  const torch::Tensor blocked = (std::get<0>(near.min(1)) < 0.2).nonzero();
  return blocked.numel() == 0 ? kFarthest : 0.3 + kStep * static_cast<double>(blocked[0][0].item<int64_t>());
}

/// The parts of a piece of furniture around its seat, in axes of `heading` about the seat's middle.
struct Around {
  Vector2d back = Vector2d::Zero();  ///< world (x, z): where the weight of what is taller than the seat lies, metres^2
  bool upside_down = false;
};

/// Legs in the air stand at the corners with nothing between them; arm and back rests run along a side.
Around around_seat(const TopView& view, const LevelArea& seat, const Vector2d& middle, double heading) {
  const Vector2d ahead = ahead_of(heading), left = left_of(heading);
  Vector2d half = Vector2d::Zero();
  for (int iz = 0; iz < view.nz; ++iz)
    for (int ix = 0; ix < view.nx; ++ix)
      if (view.height[view.at(ix, iz)] >= 0) {
        const Vector2d p = view.point(ix, iz) - middle;
        half = half.cwiseMax(Vector2d(std::abs(p.dot(left)), std::abs(p.dot(ahead))));
      }
  Around out;
  std::array<int, 4> corner{}, side{};
  double weight = 0;
  for (int iz = 0; iz < view.nz; ++iz)
    for (int ix = 0; ix < view.nx; ++ix) {
      const double taller = static_cast<double>(view.height[view.at(ix, iz)]) - seat.height;
      if (taller < kTaller) continue;
      const Vector2d p = view.point(ix, iz) - middle;
      out.back += taller * taller * p;
      weight += taller * taller;
      const double u = p.dot(left) / half.x(), v = p.dot(ahead) / half.y();
      if (std::abs(u) > 0.5 && std::abs(v) > 0.5) corner[(u > 0 ? 1 : 0) + (v > 0 ? 2 : 0)]++;
      if (std::abs(u) < 0.3 && std::abs(v) > 0.5) side[v > 0 ? 0 : 1]++;
      if (std::abs(v) < 0.3 && std::abs(u) > 0.5) side[u > 0 ? 2 : 3]++;
    }
  if (weight > 0) out.back /= weight;
  out.upside_down = std::all_of(corner.begin(), corner.end(), [](int n) { return n > 0; }) &&
                    std::count(side.begin(), side.end(), 0) >= 3;
  return out;
}

Vector2d middle_of(const LevelArea& area) {
  Vector2d sum = Vector2d::Zero();
  for (const Vector2d& p : area.points) sum += p;
  return sum / static_cast<double>(area.points.size());
}

/// The first area and those that go on with it at its height, cushions with gaps between them: on one at the end of a
/// sofa the arm rest is nearer than the back rest, which is behind all of them.
LevelArea with_other_cushions(const std::vector<LevelArea>& areas) {
  constexpr double kGap = 0.15, kSame = 0.04;  // metres
  const auto box_of = [](const LevelArea& area) {
    Eigen::AlignedBox2d box;
    for (const Vector2d& p : area.points) box.extend(p);
    return box;
  };
  LevelArea out = areas.front();
  Eigen::AlignedBox2d all = box_of(out);
  std::vector<char> taken(areas.size(), 0);
  for (bool more = true; more;) {
    more = false;
    for (size_t k = 1; k < areas.size(); ++k) {
      const Eigen::AlignedBox2d box = box_of(areas[k]);
      if (taken[k] || std::abs(areas[k].height - out.height) > kSame || all.exteriorDistance(box) > kGap) continue;
      taken[k] = more = true;
      out.points.insert(out.points.end(), areas[k].points.begin(), areas[k].points.end());
      all.extend(box);
    }
  }
  return out;
}

/// Where along a heading the pelvis rests: between the edges of the seat near the line through its middle.
Vector2d resting_place(const LevelArea& seat, const Vector2d& middle, double heading, double cell) {
  const Vector2d ahead = ahead_of(heading), left = left_of(heading);
  double lowest = 1e9, highest = -1e9, right = 1e9, leftmost = -1e9;
  for (const Vector2d& p : seat.points) {
    right = std::min(right, (p - middle).dot(left));
    leftmost = std::max(leftmost, (p - middle).dot(left));
  }
  const Vector2d line = middle + 0.5 * (right + leftmost) * left;
  for (const Vector2d& p : seat.points) {
    if (std::abs((p - line).dot(left)) > 0.12) continue;
    lowest = std::min(lowest, (p - line).dot(ahead) - cell / 2);
    highest = std::max(highest, (p - line).dot(ahead) + cell / 2);
  }
  if (lowest > highest) return line;
  const double rear = lowest + kMargin, front = highest - kMargin;
  const double at = rear > front ? (lowest + highest) / 2 : std::clamp(highest - kFront, rear, front);
  return line + at * ahead;
}

/// The heading of a person on a seat: away from the back rest, along the furniture's own axes where it is near to one.
double facing(const Scene& scene, const Mesh& mesh, const TopView& view, const LevelArea& seat, const Vector2d& middle,
              double axis, const Vector2d& back) {
  std::array<double, 4> sides{};
  for (int k = 0; k < 4; ++k) sides[static_cast<size_t>(k)] = wrapped(axis + k * M_PI / 2);
  if (back.norm() > 0.06) {
    const double away = heading_of(-back);
    const auto apart = [&](double side) { return std::abs(wrapped(side - away)); };
    const double nearest =
        *std::min_element(sides.begin(), sides.end(), [&](double a, double b) { return apart(a) < apart(b); });
    return apart(nearest) < 0.5 ? nearest : away;
  }
  // Without a back rest one sits down from the longer sides, where the floor is free.
  double best = sides[0], most = -1;
  for (const double side : sides) {
    double depth = 0, width = 0;
    for (const Vector2d& p : seat.points) {
      depth = std::max(depth, std::abs((p - middle).dot(ahead_of(side))));
      width = std::max(width, std::abs((p - middle).dot(left_of(side))));
    }
    const Vector3d from(middle.x(), view.floor + seat.height, middle.y());
    const double room = free_ahead(scene, mesh.name, from, side) * (depth > 1.3 * width ? 0.3 : 1);
    if (room > most + 1e-6) {
      most = room;
      best = side;
    }
  }
  return best;
}

/// The chair with its ends. @param view of its mesh
Chair with_ends(Chair chair, const TopView& view) {
  constexpr double kWide = 1.0, kFromEnd = 0.35, kSame = 0.08, kGap = 0.1;  // metres
  const Vector2d seat = on_ground(chair.seat()), left = left_of(chair.heading());
  const auto seat_at = [&](const Vector2d& p) {
    const Vector2d cell = (p - view.origin) / view.cell;
    const long x = std::lround(cell.x()), z = std::lround(cell.y());
    if (x < 0 || z < 0 || x >= view.nx || z >= view.nz) return false;
    const size_t at = view.at(static_cast<int>(x), static_cast<int>(z));
    return std::abs(static_cast<double>(view.height[at]) - chair.seat_height) < kSame;
  };
  // How far the seat goes on along the line on which one sits, gaps between cushions bridged.
  const auto reach = [&](double side) {
    double last = 0;
    for (double far = 0; far - last < kGap; far += view.cell)
      if (seat_at(seat + side * far * left)) last = far;
    return last;
  };
  const double leftmost = reach(1), rightmost = -reach(-1);
  chair.right_end = chair.left_end = 0;
  if (leftmost - rightmost < kWide) return chair;
  chair.right_end = rightmost + kFromEnd;
  chair.left_end = leftmost - kFromEnd;
  return chair;
}

/// Throws Error(name, ...) saying why an object is no chair.
Chair chair_from(const Scene& scene, const Mesh& mesh, double lowest, double highest, bool force) {
  const TopView view = view_from_above(mesh);
  const std::vector<LevelArea> areas = level_areas(view, force ? 0.05 : lowest, force ? 2.0 : highest);
  if (areas.empty() || areas.front().inner_radius < kSeatRadius) {
    const std::vector<LevelArea> others = level_areas(view, 0.05, 3.0);
    if (others.empty() || others.front().inner_radius < kSeatRadius)
      throw Error(mesh.name, "has no seat: no level area of 0.3 x 0.3 m");
    const double height = others.front().height;
    throw Error(mesh.name, fmt::format("is too {} to sit on: its seat is {:.2f} m over the floor, seats are {} to {} m",
                                       height < lowest ? "low" : "high", height, lowest, highest));
  }
  const LevelArea& seat = areas.front();
  std::vector<Vector2d> outline;
  const torch::Tensor vertices = mesh.vertices.contiguous();
  const auto v = vertices.accessor<float, 2>();
  for (int64_t i = 0; i < v.size(0); ++i) outline.emplace_back(v[i][0], v[i][2]);
  const double axis = rectangle_heading(outline);
  const Vector2d middle = middle_of(seat);
  const Around around = around_seat(view, seat, middle_of(with_other_cushions(areas)), axis);
  if (around.upside_down && !force) throw Error(mesh.name, "stands upside down: its legs are in the air");
  const double heading = facing(scene, mesh, view, seat, middle, axis, around.back);
  return with_ends(
      {mesh.name, mesh, seat_frame(resting_place(seat, middle, heading, view.cell), view.floor, heading), seat.height},
      view);
}

}  // namespace

double Chair::heading() const { return heading_of(on_ground(frame.linear().col(2))); }
Vector3d Chair::seat() const { return frame * Vector3d(0, seat_height, 0); }
Vector3d Chair::off(const Vector3d& pelvis) const {
  const Vector3d own = frame.inverse() * pelvis;
  // The place itself counts where it lies beyond an end.
  const double aside = std::clamp(own.x(), std::min(0.0, right_end), std::max(0.0, left_end));
  return own - Vector3d(aside, seat_height, 0);
}

Chair find_chair(const Scene& scene, const std::string& name, bool force) {
  const Mesh mesh = object_mesh(scene, name);
  if (mesh.faces.numel() == 0) {
    const std::vector<std::string> names = object_names(scene);
    std::vector<std::string> copies;
    for (const std::string& other : names)
      if (other.rfind(name + ".", 0) == 0) copies.push_back(other);
    if (copies.size() == 1) return find_chair(scene, copies[0], force);
    if (copies.size() > 1)
      throw Error(scene.name.empty() ? "scene" : scene.name,
                  fmt::format("has several of '{}': {}", name, fmt::join(copies, ", ")));
    throw Error(scene.name.empty() ? "scene" : scene.name,
                fmt::format("has no object '{}'; there {} {}", name, names.size() == 1 ? "is" : "are",
                            names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
  }
  return chair_from(scene, mesh, kLowestSeat, kHighestSeat, force);
}

Chair nearest_place(const Chair& chair, const Vector2d& to) {
  Chair out = chair;
  const Vector2d left = left_of(chair.heading());
  const double aside = std::clamp((to - on_ground(chair.seat())).dot(left), chair.right_end, chair.left_end);
  out.frame.translation() += aside * Vector3d(left.x(), 0, left.y());
  out.right_end -= aside;
  out.left_end -= aside;
  return out;
}

std::vector<Chair> find_chairs(const Scene& scene) {
  std::vector<Chair> chairs;
  for (const std::string& name : object_names(scene)) {
    const Mesh mesh = object_mesh(scene, name);
    if (mesh.faces.numel() == 0) continue;
    try {
      chairs.push_back(chair_from(scene, mesh, 0.3, 0.6, false));
    } catch (const Error&) {
      continue;  // no chair: walls, tables, shelves
    }
  }
  const auto seats =
      std::stable_partition(chairs.begin(), chairs.end(), [](const Chair& c) { return !is_named_otherwise(c.name); });
  if (seats != chairs.begin()) chairs.erase(seats, chairs.end());
  return chairs;
}

Chair chair_at(const Scene& scene, const Vector3d& point, double heading, bool force) {
  const Scene furniture = obstacles_of(scene);
  const auto where = fmt::format("({:.2f}, {:.2f}, {:.2f})", point.x(), point.y(), point.z());
  if (furniture.meshes.empty()) throw Error("seat at " + where, "the scene has nothing to sit on");
  const torch::Tensor from = torch::tensor({point.x(), point.y() + 0.2, point.z()}, torch::kFloat).view({1, 3});
  const torch::Tensor down = torch::tensor({0.F, -1.F, 0.F}).view({1, 3});
  const RayHits hits = SceneQuery(furniture).cast(from, down);
  if (!hits.hit.item<bool>()) throw Error("seat at " + where, "nothing to sit on is below that point");
  const std::string name = object_of_mesh(furniture.meshes[static_cast<size_t>(hits.mesh.item<int64_t>())].name);
  Chair chair{name, object_mesh(scene, name), {}, 0};
  const double floor = std::get<0>(chair.mesh.vertices.min(0))[1].item<double>();
  chair.frame = seat_frame({point.x(), point.z()}, floor, heading);
  chair.seat_height = hits.points[0][1].item<double>() - floor;
  if (!force && (chair.seat_height < kLowestSeat || chair.seat_height > kHighestSeat))
    throw Error("seat at " + where, fmt::format("{} is {:.2f} m high there, seats are {} to {} m", name,
                                                chair.seat_height, kLowestSeat, kHighestSeat));
  return with_ends(chair, view_from_above(chair.mesh));
}

std::optional<Chair> chair_of(const Clip& clip, const Scene& scene) {
  const std::vector<Stay> stays = stays_of(clip);
  if (stays.empty()) return {};
  const Stay& stay = stays.front();
  Chair chair = chair_at(scene, stay.rest, stay.heading);
  for (size_t o = 0; o < clip.object_names.size(); ++o) {
    if (clip.object_names[o] != chair.name) continue;
    const torch::Tensor pose = clip.object_pose[stay.first][static_cast<int64_t>(o)].to(torch::kDouble).contiguous();
    const double yaw = pose.data_ptr<double>()[4];
    if (std::abs(wrapped(yaw - stay.heading)) > 0.8) break;  // sat on from another side, as beds and stools are
    chair.frame.linear() = Eigen::AngleAxisd(yaw, Vector3d::UnitY()).toRotationMatrix();
    chair = with_ends(chair, view_from_above(chair.mesh));
  }
  return chair;
}

}  // namespace inhabit::interact
