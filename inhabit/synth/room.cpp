#include "inhabit/synth/room.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "inhabit/math/random.h"
#include "inhabit/scene/shapes.h"
#include "inhabit/synth/free_space.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWallThickness = 0.12;
constexpr double kBodyRadius = 0.22;  // of a person who walks, as in every test of what can be reached

// A rectangle on the floor.
struct Patch {
  Vector2d center, half;
  double yaw = 0;
};

// Whether two patches overlap (no axis of either separates them).
bool overlap(const Patch& a, const Patch& b) {
  auto axes = [](const Patch& p) {
    return std::array<Vector2d, 2>{Vector2d(std::cos(p.yaw), -std::sin(p.yaw)),
                                   Vector2d(std::sin(p.yaw), std::cos(p.yaw))};
  };
  const auto ax = axes(a), bx = axes(b);
  const Vector2d d = b.center - a.center;
  for (const auto& set : {ax, bx})
    for (const Vector2d& n : set) {
      auto extent = [&](const Patch& p, const std::array<Vector2d, 2>& own) {
        return p.half.x() * std::abs(own[0].dot(n)) + p.half.y() * std::abs(own[1].dot(n));
      };
      if (std::abs(d.dot(n)) >= extent(a, ax) + extent(b, bx)) return false;
    }
  return true;
}

// The patch [x0, x1] x [z0, z1] of a piece's own frame, in the world.
Patch own_patch(const Furniture& piece, double x0, double x1, double z0, double z1) {
  const Vector3d c = piece.pose * Vector3d((x0 + x1) / 2, 0, (z0 + z1) / 2);
  const Vector3d front = piece.pose.linear() * Vector3d::UnitZ();
  return {{c.x(), c.z()}, {(x1 - x0) / 2, (z1 - z0) / 2}, std::atan2(front.x(), front.z())};
}

Patch footprint(const Furniture& piece, double margin) {
  const Eigen::AlignedBox3d b = piece.bounds();
  return own_patch(piece, b.min().x() - margin, b.max().x() + margin, b.min().z() - margin, b.max().z() + margin);
}

// A point on wall `side` (0: -z, 1: +x, 2: +z, 3: -x), `along` it from its middle and `in` into the room, and the yaw
// with which a piece faces the room there.
struct AtWall {
  Vector2d point;
  double yaw;
};
AtWall at_wall(const Vector2d& size, int side, double along, double in) {
  switch (side) {
    case 0:
      return {{along, -size.y() / 2 + in}, 0};
    case 1:
      return {{size.x() / 2 - in, along}, -M_PI / 2};
    case 2:
      return {{-along, size.y() / 2 - in}, M_PI};
    default:
      return {{-size.x() / 2 + in, -along}, M_PI / 2};
  }
}
double wall_length(const Vector2d& size, int side) { return side % 2 == 0 ? size.x() : size.y(); }

// What has been placed so far and what must stay free.
class Layout {
 public:
  explicit Layout(Room& room) : room_(room), space_(free_space(room)) {}

  void keep_free(const Patch& patch) {
    free_.push_back(patch);
    kept_free_ = free_.size();
  }
  void keep_low(const Patch& patch) { low_.push_back(patch); }  // for pieces under a window sill
  void must_reach(const Vector2d& p) {
    goals_.push_back(p);
    kept_goals_ = goals_.size();
  }

  // Adds all of `pieces` with the patches that they need free, or none: inside the room, apart from one another, and
  // with every seat so far within walking reach.
  bool add(const std::vector<Furniture>& pieces, const std::vector<Patch>& need) {
    for (const Patch& n : need)
      if (!inside(n, 0.0) || hits(n, solid_)) return false;
    for (size_t i = 0; i < pieces.size(); ++i) {
      const Patch p = footprint(pieces[i], 0);
      if (!inside(p, 0.01) || hits(footprint(pieces[i], 0.02), solid_) || hits(p, free_) || hits(p, need)) return false;
      if (pieces[i].bounds().max().y() > 0.95 && hits(p, low_)) return false;
      for (size_t k = 0; k < i; ++k)
        if (overlap(footprint(pieces[i], 0.02), footprint(pieces[k], 0))) return false;
    }
    FreeSpace space = space_;
    std::vector<Vector2d> goals = goals_;
    for (const Furniture& piece : pieces) {
      add_obstacle(space, piece);
      for (const Surface& s : piece.surfaces)
        if (s.kind == Surface::Kind::seat) goals.push_back(place_before(piece, s));
    }
    const std::vector<int32_t> region = walkable_regions(space, kBodyRadius);
    for (const Vector2d& g : goals) {
      const Vector2d cell = (g - space.origin) / space.cell;
      const long i = std::lround(cell.x()), k = std::lround(cell.y());
      if (i < 0 || k < 0 || i >= space.nx || k >= space.nz) return false;
      if (region[static_cast<size_t>(k) * space.nx + i] != 1 || !walkable(space, g, kBodyRadius)) return false;
    }
    for (const Furniture& piece : pieces) {
      room_.furniture.push_back(piece);
      solid_.push_back(footprint(piece, 0));
    }
    free_.insert(free_.end(), need.begin(), need.end());
    space_ = std::move(space);
    goals_ = std::move(goals);
    return true;
  }

  void remove_last() {
    room_.furniture.pop_back();
    solid_.pop_back();
    free_.resize(kept_free_);
    goals_.resize(kept_goals_);
    space_ = free_space(room_);
  }

 private:
  bool inside(const Patch& p, double margin) const {
    const double c = std::abs(std::cos(p.yaw)), s = std::abs(std::sin(p.yaw));
    const Vector2d extent(c * p.half.x() + s * p.half.y(), s * p.half.x() + c * p.half.y());
    return ((p.center.cwiseAbs() + extent).array() <= (room_.size / 2).array() - margin).all();
  }
  static bool hits(const Patch& p, const std::vector<Patch>& others) {
    return std::any_of(others.begin(), others.end(), [&](const Patch& o) { return overlap(p, o); });
  }

  Room& room_;
  FreeSpace space_;
  std::vector<Patch> solid_, free_, low_;
  std::vector<Vector2d> goals_;
  size_t kept_free_ = 0, kept_goals_ = 0;  // those of the room itself, before any furniture
};

// Places `piece` with its back to a random place of a random wall.
void put_at_wall(Furniture& piece, const Room& room, std::mt19937_64& random, double gap) {
  const int side = uniform_int(random, 0, 3);
  const Eigen::AlignedBox3d b = piece.bounds();
  const double slack = (wall_length(room.size, side) - b.sizes().x()) / 2 - 0.03;
  // Half of the time in a corner, as people do.
  double along = uniform(random, -1, 1) * slack;
  if (chance(random, 0.4)) along = (along < 0 ? -1 : 1) * (slack - uniform(random, 0, 0.15));
  const AtWall at = at_wall(room.size, side, along, gap - b.min().z());
  piece.place(at.point.x(), at.point.y(), at.yaw);
}

// Places `piece` in the frame of `anchor` at (x, z), turned by `yaw` from it.
void put_beside(Furniture& piece, const Furniture& anchor, double x, double z, double yaw) {
  piece.pose = anchor.pose * Eigen::Translation3d(x, 0, z) * Eigen::AngleAxisd(yaw, Vector3d::UnitY());
}

Patch before(const Furniture& piece, double distance) {
  const Eigen::AlignedBox3d b = piece.bounds();
  return own_patch(piece, b.min().x(), b.max().x(), b.max().z() + 0.001, b.max().z() + distance);
}

Furniture any_chair(std::mt19937_64& random, double arms) {
  return chance(random, arms) ? make_armchair(random) : make_chair(random);
}

using Group = std::pair<std::vector<Furniture>, std::vector<Patch>>;  // pieces and what they need free

Group dining_group(const Room& room, std::mt19937_64& random) {
  const double width = uniform(random, 0.8, 1.8), depth = uniform(random, 0.75, 0.95);
  const double height = uniform(random, 0.72, 0.76);
  std::vector<Furniture> pieces = {make_table(random, width, depth, height)};
  Furniture& table = pieces[0];
  const Vector2d slack = room.size / 2 - Vector2d(1.2, 1.2);
  const double x = uniform(random, -1, 1) * slack.x(), z = uniform(random, -1, 1) * slack.y();
  const double turn = uniform_int(random, 0, 1) * M_PI / 2;
  table.place(x, z, chance(random, 0.8) ? turn : turn + uniform(random, -0.5, 0.5));
  const double arms = uniform(random, 0, 1);
  const uint64_t style = random();  // chairs of one set look alike
  std::vector<Patch> need;
  const int along = width > 1.3 ? 2 : 1;
  for (int side = 0; side < 4; ++side) {
    const bool end = side % 2 == 1;
    for (int i = 0; i < (end ? 1 : along); ++i) {
      if (chance(random, end ? 0.6 : 0.3)) continue;
      std::mt19937_64 same(style);
      Furniture chair = any_chair(same, arms);
      // Drawn back from the table far enough to stand between the two.
      const double gap = uniform(random, 0.52, 0.70), skew = uniform(random, -0.3, 0.3);
      const double out = (end ? width : depth) / 2 + gap + chair.bounds().max().z();
      const double shift = end || along == 1 ? uniform(random, -0.1, 0.1) : (i - 0.5) * width / 2;
      const double a = side * M_PI / 2;  // direction from the table to this side, from +Z towards +X
      put_beside(chair, table, std::sin(a) * out + std::cos(a) * shift, std::cos(a) * out - std::sin(a) * shift,
                 a + M_PI + skew);
      pieces.push_back(std::move(chair));
    }
  }
  return {std::move(pieces), std::move(need)};
}

Group sofa_group(const Room& room, std::mt19937_64& random) {
  std::vector<Furniture> pieces = {make_sofa(random, uniform_int(random, 1, 10) > 4 ? 3 : 2)};
  put_at_wall(pieces[0], room, random, uniform(random, 0.03, 0.12));
  const Eigen::AlignedBox3d b = pieces[0].bounds();
  std::vector<Patch> need = {before(pieces[0], 0.45)};
  double front = b.max().z() + 0.9;
  if (chance(random, 0.75)) {
    const double gap = uniform(random, 0.53, 0.66), depth = uniform(random, 0.45, 0.65);
    const double width = uniform(random, 0.7, 1.2), height = uniform(random, 0.36, 0.46);
    Furniture table = make_table(random, width, depth, height);
    put_beside(table, pieces[0], uniform(random, -0.15, 0.15), b.max().z() + gap + depth / 2, 0);
    front = b.max().z() + gap + depth / 2;
    pieces.push_back(std::move(table));
  }
  for (const double s : {-1.0, 1.0}) {
    if (!chance(random, 0.35)) continue;
    Furniture chair = make_armchair(random);
    const double turn = uniform(random, 0.9, 1.5), x = b.max().x() + uniform(random, 0.35, 0.6);
    put_beside(chair, pieces[0], s * x, front + uniform(random, 0.0, 0.3), -s * turn);
    pieces.push_back(std::move(chair));
  }
  return {std::move(pieces), std::move(need)};
}

Group bed_group(const Room& room, std::mt19937_64& random) {
  std::vector<Furniture> pieces = {make_bed(random)};
  put_at_wall(pieces[0], room, random, 0.02);
  const Eigen::AlignedBox3d b = pieces[0].bounds();
  const double stand_height = uniform(random, 0.45, 0.58), stand = uniform(random, 0.38, 0.48);
  const uint64_t style = random();
  const double first = chance(random, 0.5) ? 1 : -1;
  for (const double s : {first, -first}) {
    if (!chance(random, s == first ? 0.8 : 0.4)) continue;
    std::mt19937_64 same(style);
    Furniture table = make_table(same, stand, 0.38, stand_height);
    put_beside(table, pieces[0], s * (b.max().x() + stand / 2 + 0.03), b.min().z() + 0.2, 0);
    pieces.push_back(std::move(table));
  }
  const double x = b.max().x();
  std::vector<Patch> need = {first > 0 ? own_patch(pieces[0], x + 0.001, x + 0.55, -0.4, b.max().z())
                                       : own_patch(pieces[0], -x - 0.55, -x - 0.001, -0.4, b.max().z())};
  return {std::move(pieces), std::move(need)};
}

Group desk_group(const Room& room, std::mt19937_64& random) {
  const double width = uniform(random, 0.9, 1.5), depth = uniform(random, 0.55, 0.75);
  const double height = uniform(random, 0.71, 0.76);
  std::vector<Furniture> pieces = {make_table(random, width, depth, height)};
  put_at_wall(pieces[0], room, random, 0.02);
  Furniture chair = any_chair(random, 0.6);
  const double gap = uniform(random, 0.52, 0.68), shift = uniform(random, -0.15, 0.15);
  const double out = depth / 2 + gap + chair.bounds().max().z();
  put_beside(chair, pieces[0], shift, out, M_PI + uniform(random, -0.4, 0.4));
  pieces.push_back(std::move(chair));
  return {std::move(pieces), {}};
}

Group shelf_group(const Room& room, std::mt19937_64& random) {
  std::vector<Furniture> pieces = {make_shelf(random)};
  put_at_wall(pieces[0], room, random, 0.015);
  std::vector<Patch> need = {before(pieces[0], 0.6)};
  return {std::move(pieces), std::move(need)};
}

// A seat on its own: against a wall or standing free.
Group lone_seat(const Room& room, std::mt19937_64& random) {
  const int kind = uniform_int(random, 0, 3);
  std::vector<Furniture> pieces = {kind == 0   ? make_stool(random)
                                   : kind == 1 ? make_chair(random)
                                               : make_armchair(random)};
  if (chance(random, 0.6)) {
    put_at_wall(pieces[0], room, random, uniform(random, 0.03, 0.15));
  } else {
    const Vector2d slack = room.size / 2 - Vector2d(0.6, 0.6);
    const double x = uniform(random, -1, 1) * slack.x(), z = uniform(random, -1, 1) * slack.y();
    pieces[0].place(x, z, std::atan2(-x, -z) + uniform(random, -0.8, 0.8));  // more or less to the middle
  }
  std::vector<Patch> need = {before(pieces[0], 0.5)};
  return {std::move(pieces), std::move(need)};
}

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
    torch::Tensor turn = torch::empty({3, 3}), shift = torch::empty({3});
    for (int r = 0; r < 3; ++r) {
      shift[r] = furniture[i].pose.translation()[r];
      for (int c = 0; c < 3; ++c) turn[r][c] = furniture[i].pose.linear()(r, c);
    }
    for (size_t m = 0; m < furniture[i].meshes.size(); ++m) {
      Mesh mesh = furniture[i].meshes[m];
      mesh.name = m == 0 ? name : name + "." + std::to_string(m);
      mesh.vertices = torch::matmul(mesh.vertices, turn.t()) + shift;
      out.meshes.push_back(std::move(mesh));
    }
  }
  out.meshes.insert(out.meshes.end(), decor.begin(), decor.end());
  return out;
}

void add_walls(Room& room, std::mt19937_64& random, std::vector<Vector2d>* doors) {
  struct Opening {
    int side;
    double along, half, low, high;
    bool door;
  };
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
      if (o.door && doors != nullptr) doors->push_back(at_wall(room.size, side, o.along, 0).point);
    }
    wall(from, end, 0, room.height);
  }
  if (!frames.empty()) room.decor.push_back(frames.mesh("frames", {0.82F, 0.81F, 0.78F}));
}

Room make_room(std::mt19937_64& random) {
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
  Room room;
  const double x = uniform(random, 3.5, 8.0), z = uniform(random, 3.5, 8.0);
  room.size = {x, z};
  room.height = uniform(random, 2.4, 2.8);
  room.floor_color = floors[static_cast<size_t>(uniform_int(random, 0, 4))];
  room.wall_color = paints[static_cast<size_t>(uniform_int(random, 0, 5))];
  std::vector<Vector2d> doors;
  add_walls(room, random, &doors);

  Layout layout(room);
  for (const Vector2d& door : doors) {
    // A metre into the room, as wide as a door, stays free.
    const Vector2d to_wall = room.size / 2 - door.cwiseAbs();
    const bool on_x = to_wall.x() < to_wall.y();
    const Vector2d in = on_x ? Vector2d(door.x() > 0 ? -1 : 1, 0) : Vector2d(0, door.y() > 0 ? -1 : 1);
    layout.keep_free({door + 0.5 * in, on_x ? Vector2d(0.499, 0.5) : Vector2d(0.5, 0.499), 0});
    layout.must_reach(door + 0.5 * in);
  }
  auto try_to_add = [&](Group (*make)(const Room&, std::mt19937_64&), int attempts) {
    for (int i = 0; i < attempts; ++i) {
      const auto [pieces, need] = make(room, random);
      if (layout.add(pieces, need)) return true;
    }
    return false;
  };
  // The large pieces first; what the room is used for varies.
  const double area = x * z;
  const bool living = chance(random, 0.65), sleeping = chance(random, 0.4), eating = chance(random, 0.65);
  if (sleeping) try_to_add(bed_group, 20);
  if (living || !(sleeping || eating)) try_to_add(sofa_group, 20);
  if (eating) try_to_add(dining_group, 20);
  if (chance(random, 0.5)) try_to_add(desk_group, 12);
  const int shelves = uniform_int(random, 1, 1 + static_cast<int>(area / 14));
  for (int i = 0; i < shelves; ++i) try_to_add(shelf_group, 12);
  const int seats = uniform_int(random, 1, 1 + static_cast<int>(area / 16));
  for (int i = 0; i < seats; ++i) try_to_add(lone_seat, 12);
  auto has_seat = [&] {
    return std::any_of(room.furniture.begin(), room.furniture.end(), [](const Furniture& f) {
      return std::any_of(f.surfaces.begin(), f.surfaces.end(),
                         [](const Surface& s) { return s.kind == Surface::Kind::seat; });
    });
  };
  // A small room full of the rest may have no place left for a seat: then one piece after the other goes.
  while (!has_seat() && !try_to_add(lone_seat, 60) && !room.furniture.empty()) layout.remove_last();
  return room;
}

}  // namespace inhabit
