#include "inhabit/synth/layout.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "inhabit/interruption.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBodyRadius = 0.22;  // of a person who walks, as in every test of what can be reached

bool hits(const Patch& p, const std::vector<Patch>& others) {
  return std::any_of(others.begin(), others.end(), [&](const Patch& o) { return overlap(p, o); });
}

// The patch [x0, x1] x [z0, z1] of a piece's own frame, in the world.
Patch own_patch(const Furniture& piece, double x0, double x1, double z0, double z1) {
  const Vector3d c = piece.pose * Vector3d((x0 + x1) / 2, 0, (z0 + z1) / 2);
  return {on_ground(c), {(x1 - x0) / 2, (z1 - z0) / 2}, heading_of(on_ground(piece.pose.linear().col(2)))};
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
  const Vector2d slack = room.size / 2 - Vector2d(1.2, 1.2);
  const double x = uniform(random, -1, 1) * slack.x(), z = uniform(random, -1, 1) * slack.y();
  const double angle = uniform_int(random, 0, 1) * M_PI / 2;
  pieces[0].place(x, z, chance(random, 0.8) ? angle : angle + uniform(random, -0.5, 0.5));
  const double arms = uniform(random, 0, 1);
  const uint64_t style = random();  // chairs of one set look alike
  std::vector<Patch> need;
  const int along = width > 1.3 ? 2 : 1;
  for (int side = 0; side < 4; ++side) {
    const bool end = side % 2 == 1;
    for (int i = 0; i < (end ? 1 : along); ++i) {
      if (chance(random, end ? 0.5 : 0.2)) continue;
      std::mt19937_64 same(style);
      Furniture chair = any_chair(same, arms);
      // Drawn back from the table far enough to stand between the two.
      const double gap = uniform(random, 0.52, 0.70), skew = uniform(random, -0.3, 0.3);
      const double out = (end ? width : depth) / 2 + gap + chair.bounds().max().z();
      const double shift = end || along == 1 ? uniform(random, -0.1, 0.1) : (i - 0.5) * width / 2;
      const double a = side * M_PI / 2;  // direction from the table to this side, from +Z towards +X
      put_beside(chair, pieces[0], std::sin(a) * out + std::cos(a) * shift, std::cos(a) * out - std::sin(a) * shift,
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
    const double angle = uniform(random, 0.9, 1.5), x = b.max().x() + uniform(random, 0.35, 0.6);
    put_beside(chair, pieces[0], s * x, front + uniform(random, 0.0, 0.3), -s * angle);
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
  return {std::move(pieces), std::vector<Patch>()};
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
    pieces[0].place(x, z, heading_of({-x, -z}) + uniform(random, -0.8, 0.8));  // more or less to the middle
  }
  std::vector<Patch> need = {before(pieces[0], 0.5)};
  return {std::move(pieces), std::move(need)};
}

}  // namespace

// No axis of either separates two that overlap.
bool overlap(const Patch& a, const Patch& b) {
  auto axes = [](const Patch& p) { return std::array<Vector2d, 2>{left_of(p.yaw), ahead_of(p.yaw)}; };
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

Patch footprint(const Furniture& piece, double margin) {
  const Eigen::AlignedBox3d b = piece.bounds();
  return own_patch(piece, b.min().x() - margin, b.max().x() + margin, b.min().z() - margin, b.max().z() + margin);
}

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

Layout::Layout(Room& room, const std::vector<Opening>& openings) : room_(room), space_(free_space(room)) {
  for (const Furniture& piece : room.furniture) solid_.push_back(footprint(piece));
  for (const Opening& o : openings) {
    const double deep = o.door ? 1.0 : 0.4;  // of what stays free of furniture, or of high furniture
    const Vector2d middle = at_wall(room.size, o.side, o.along, deep / 2).point;
    const Vector2d half = o.side % 2 == 0 ? Vector2d(o.half, deep / 2 - 0.001) : Vector2d(deep / 2 - 0.001, o.half);
    (o.door ? free_ : low_).push_back({middle, half, 0});
    if (o.door) goals_.push_back(middle);
  }
  doors_ = goals_.size();
}

bool Layout::add(const std::vector<Furniture>& pieces, const std::vector<Patch>& need) {
  interruption_point();
  for (const Patch& n : need)
    if (!inside(n, 0.0) || hits(n, solid_)) return false;
  for (size_t i = 0; i < pieces.size(); ++i) {
    const Patch p = footprint(pieces[i], 0);
    if (!inside(p, 0.01) || hits(footprint(pieces[i], 0.02), solid_) || hits(p, free_) || hits(p, need)) return false;
    if (pieces[i].bounds().max().y() > 0.95 && hits(p, low_)) return false;
    for (size_t k = 0; k < i; ++k)
      if (overlap(footprint(pieces[i], 0.02), footprint(pieces[k], 0))) return false;
  }
  if (test_ && !std::all_of(pieces.begin(), pieces.end(), test_)) return false;
  FreeSpace space = space_;
  std::vector<Vector2d> goals = goals_;
  for (const Furniture& piece : pieces) {
    add_obstacle(space, piece);
    for (const Surface& s : piece.surfaces)
      if (s.kind == Surface::Kind::seat && !test_) goals.push_back(place_before(piece, s));
  }
  if (!test_) {
    const std::vector<int32_t> region = walkable_regions(space, kBodyRadius);
    for (const Vector2d& g : goals) {
      const Vector2d cell = (g - space.origin) / space.cell;
      const long i = std::lround(cell.x()), k = std::lround(cell.y());
      if (i < 0 || k < 0 || i >= space.nx || k >= space.nz) return false;
      if (region[static_cast<size_t>(k) * space.nx + i] != 1 || !walkable(space, g, kBodyRadius)) return false;
    }
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

void Layout::remove_last() {
  room_.furniture.pop_back();
  solid_.pop_back();
  free_.resize(doors_);
  goals_.resize(doors_);
  space_ = free_space(room_);
}

bool Layout::inside(const Patch& p, double margin) const {
  const double c = std::abs(std::cos(p.yaw)), s = std::abs(std::sin(p.yaw));
  const Vector2d extent(c * p.half.x() + s * p.half.y(), s * p.half.x() + c * p.half.y());
  return ((p.center.cwiseAbs() + extent).array() <= (room_.size / 2).array() - margin).all();
}

void furnish(Layout& layout, std::mt19937_64& random) {
  auto try_to_add = [&](Group (*make)(const Room&, std::mt19937_64&), int attempts) {
    for (int i = 0; i < attempts; ++i) {
      const auto [pieces, need] = make(layout.room(), random);
      if (layout.add(pieces, need)) return true;
    }
    return false;
  };
  // The large pieces first; what the room is used for varies.
  const double area = layout.room().size.prod();
  const bool living = chance(random, 0.65), sleeping = chance(random, 0.4), eating = chance(random, 0.65);
  if (sleeping) try_to_add(bed_group, 20);
  if (living || !(sleeping || eating)) try_to_add(sofa_group, 20);
  if (eating) try_to_add(dining_group, 20);
  if (chance(random, 0.5)) try_to_add(desk_group, 12);
  const int shelves = uniform_int(random, 1, 1 + static_cast<int>(area / 14));
  for (int i = 0; i < shelves; ++i) try_to_add(shelf_group, 12);
  const int seats = uniform_int(random, 1, 1 + static_cast<int>(area / 16));
  for (int i = 0; i < seats; ++i) try_to_add(lone_seat, 12);
}

void add_any_seat(Layout& layout, std::mt19937_64& random) {
  for (int i = 0;; ++i) {
    const auto [pieces, need] = lone_seat(layout.room(), random);
    if (layout.add(pieces, need)) return;
    // A small room full of the rest may have no place left for a seat: then one piece after the other goes.
    if (i % 60 == 59 && !layout.room().furniture.empty()) layout.remove_last();
  }
}

}  // namespace inhabit
