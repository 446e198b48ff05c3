#include "inhabit/synth/room.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/random.h"
#include "inhabit/scene/shapes.h"
#include "inhabit/synth/layout.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWallThickness = 0.12;

}  // namespace

std::string Room::object_name(size_t i) const {
  const std::string& kind = furniture[i].kind;
  const auto before_it = std::count_if(furniture.begin(), furniture.begin() + static_cast<long>(i),
                                       [&](const Furniture& f) { return f.kind == kind; });
  return kind + "_" + std::to_string(before_it);
}

Scene Room::scene() const {
  Scene out;
  out.name = "room";
  MeshBuilder floor;
  const double t = kWallThickness;
  floor.box({0, -0.05, 0}, {size.x() / 2 + t, 0.05, size.y() / 2 + t});
  out.meshes.push_back(floor.mesh("floor", floor_color));
  for (size_t i = 0; i < walls.size(); ++i) {
    MeshBuilder wall;
    wall.box(walls[i].center, walls[i].half);
    out.meshes.push_back(wall.mesh("wall_" + std::to_string(i), wall_color));
  }
  for (size_t i = 0; i < furniture.size(); ++i) {
    const std::string name = object_name(i);
    torch::Tensor rotation = torch::empty({3, 3}), shift = torch::empty({3});
    for (int r = 0; r < 3; ++r) {
      shift[r] = furniture[i].pose.translation()[r];
      for (int c = 0; c < 3; ++c) rotation[r][c] = furniture[i].pose.linear()(r, c);
    }
    for (size_t m = 0; m < furniture[i].meshes.size(); ++m) {
      Mesh mesh = furniture[i].meshes[m];
      mesh.name = m == 0 ? name : name + "." + std::to_string(m);
      mesh.vertices = torch::matmul(mesh.vertices, rotation.t()) + shift;
      out.meshes.push_back(std::move(mesh));
    }
  }
  out.meshes.insert(out.meshes.end(), decor.begin(), decor.end());
  return out;
}

std::vector<Opening> add_walls(Room& room, std::mt19937_64& random) {
  std::vector<Opening> openings;
  auto add = [&](bool door) {
    for (int attempt = 0; attempt < 40; ++attempt) {
      Opening o;
      o.side = uniform_int(random, 0, 3);
      o.door = door;
      o.half = door ? uniform(random, 0.42, 0.50) : uniform(random, 0.4, 0.95);
      o.low = door ? 0 : uniform(random, 0.85, 1.05);
      o.high = door ? uniform(random, 2.0, 2.1) : uniform(random, 2.0, 2.2);
      const double slack = wall_length(room.size, o.side) / 2 - o.half - 0.25;
      if (slack < 0) continue;
      o.along = uniform(random, -slack, slack);
      if (std::any_of(openings.begin(), openings.end(), [&](const Opening& other) {
            return other.side == o.side && std::abs(other.along - o.along) < other.half + o.half + 0.3;
          }))
        continue;
      openings.push_back(o);
      return;
    }
  };
  const int n_doors = uniform_int(random, 1, 2), n_windows = uniform_int(random, 1, 3);
  for (int i = 0; i < n_doors; ++i) add(true);
  for (int i = 0; i < n_windows; ++i) add(false);

  const double t = kWallThickness / 2;
  MeshBuilder frames;
  for (int side = 0; side < 4; ++side) {
    // A stretch of wall from `from` to `to` along it, and from `low` to `high`.
    auto stretch = [&](double from, double to, double low, double high, double thickness) {
      const AtWall at = at_wall(room.size, side, (from + to) / 2, -t);
      const Vector3d half = side % 2 == 0 ? Vector3d((to - from) / 2, (high - low) / 2, thickness)
                                          : Vector3d(thickness, (high - low) / 2, (to - from) / 2);
      return Box{{at.point.x(), (low + high) / 2, at.point.y()}, half};
    };
    auto wall = [&](double from, double to, double low, double high) {
      if (to - from > 1e-6 && high - low > 1e-6) room.walls.push_back(stretch(from, to, low, high, t));
    };
    auto frame = [&](double from, double to, double low, double high, double thickness) {
      const Box box = stretch(from, to, low, high, thickness);
      frames.box(box.center, box.half, 0.004);
    };
    std::vector<Opening> own;
    for (const Opening& o : openings)
      if (o.side == side) own.push_back(o);
    std::sort(own.begin(), own.end(), [](const Opening& a, const Opening& b) { return a.along < b.along; });
    // The walls of sides 0 and 2 close the corners.
    const double end = wall_length(room.size, side) / 2 + (side % 2 == 0 ? 2 * t : 0);
    double from = -end;
    for (const Opening& o : own) {
      const double a = o.along - o.half, b = o.along + o.half, f = 0.04, deep = t + 0.008;
      wall(from, a, 0, room.height);
      wall(a, b, 0, o.low);
      wall(a, b, o.high, room.height);
      frame(a, a + f, o.low, o.high, deep);
      frame(b - f, b, o.low, o.high, deep);
      frame(a + f, b - f, o.high - f, o.high, deep);
      if (!o.door) {
        frame(a + f, b - f, o.low, o.low + f, deep);
        frame(o.along - 0.015, o.along + 0.015, o.low + f, o.high - f, 0.015);
      }
      from = b;
    }
    wall(from, end, 0, room.height);
  }
  if (!frames.empty()) room.decor.push_back(frames.mesh("frames", {0.82F, 0.81F, 0.78F}));
  return openings;
}

void paint(Room& room, std::mt19937_64& random) {
  static const std::array<std::array<float, 3>, 5> floors = {{{0.45F, 0.29F, 0.16F},
                                                              {0.56F, 0.41F, 0.27F},
                                                              {0.24F, 0.14F, 0.08F},
                                                              {0.42F, 0.41F, 0.40F},
                                                              {0.60F, 0.53F, 0.44F}}};
  static const std::array<std::array<float, 3>, 6> paints = {{{0.82F, 0.79F, 0.72F},
                                                              {0.70F, 0.76F, 0.77F},
                                                              {0.80F, 0.70F, 0.60F},
                                                              {0.69F, 0.74F, 0.64F},
                                                              {0.78F, 0.78F, 0.79F},
                                                              {0.76F, 0.67F, 0.64F}}};
  room.floor_color = floors[static_cast<size_t>(uniform_int(random, 0, 4))];
  room.wall_color = paints[static_cast<size_t>(uniform_int(random, 0, 5))];
}

Room make_room(std::mt19937_64& random) {
  Room room;
  const double x = uniform(random, 3.5, 8.0), z = uniform(random, 3.5, 8.0);
  room.size = {x, z};
  room.height = uniform(random, 2.4, 2.8);
  paint(room, random);
  Layout layout(room, add_walls(room, random));
  furnish(layout, random);
  const bool has_seat = std::any_of(room.furniture.begin(), room.furniture.end(), [](const Furniture& f) {
    return std::any_of(f.surfaces.begin(), f.surfaces.end(),
                       [](const Surface& s) { return s.kind == Surface::Kind::seat; });
  });
  if (!has_seat) add_any_seat(layout, random);
  return room;
}

}  // namespace inhabit
