#include "inhabit/inbetween/blocked_rooms.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/interpolate.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/shapes.h"
#include "inhabit/scene/walk_path.h"

namespace inhabit::inbetween {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using torch::Tensor;

constexpr double kClear = 0.3, kEndsNear = 0.45;  // metres: of the detour, but near its ends
constexpr double kFree = 0.05, kBlocked = 0.03;   // metres: of the key poses; how deep the straight motion goes
constexpr double kLeastDistance = 2.4, kMostDistance = 3.4;  // metres, of the keys
constexpr double kSole = 0.02;                               // metres: height of the ball of a standing foot
constexpr int kTries = 2000;

/// Boxes about a common place: closed, rotated as one about the vertical.
struct Piece {
  std::string name;
  Vector2d at;  // x to the left of the straight line, z along it
  double yaw;
  std::vector<std::pair<Vector3d, Vector3d>> boxes;  // center and half size, the piece's own frame
};

Mesh mesh_of(const Piece& piece, double side) {
  MeshBuilder builder;
  for (const auto& [center, half] : piece.boxes) builder.box({side * center.x(), center.y(), center.z()}, half);
  Mesh mesh = builder.mesh(piece.name, {0.5F, 0.4F, 0.3F});
  const Tensor v = mesh.vertices.clone();
  const double yaw = side * piece.yaw, c = std::cos(yaw), s = std::sin(yaw);
  mesh.vertices.select(1, 0).copy_(c * v.select(1, 0) + s * v.select(1, 2) + side * piece.at.x());
  mesh.vertices.select(1, 2).copy_(c * v.select(1, 2) - s * v.select(1, 0) + piece.at.y());
  return mesh;
}

std::vector<Piece> table(std::mt19937_64& r) {
  const double w = uniform(r, 0.45, 0.75), d = uniform(r, 0.3, 0.45), top = uniform(r, 0.72, 0.78);
  Piece out{"table_0", {uniform(r, -0.35, 0.35), uniform(r, -0.2, 0.2)}, uniform(r, -0.5, 0.5), {}};
  out.boxes.push_back({{0, top - 0.05, 0}, {w, 0.05, d}});  // with its apron
  for (const double x : {-w + 0.05, w - 0.05})
    for (const double z : {-d + 0.05, d - 0.05})
      out.boxes.push_back({{x, top / 2 - 0.05, z}, {0.03, top / 2 - 0.05, 0.03}});
  return {out};
}

std::vector<Piece> sofa(std::mt19937_64& r) {
  const double w = uniform(r, 0.7, 1.0), back = chance(r, 0.5) ? 0.33 : -0.33;
  return {{"sofa_0",
           {uniform(r, -0.4, 0.4), uniform(r, -0.15, 0.15)},
           uniform(r, -0.5, 0.5),
           {{{0, 0.21, 0}, {w, 0.21, 0.43}}, {{0, 0.6, back}, {w, 0.2, 0.1}}}}};
}

std::vector<Piece> shelf(std::mt19937_64& r) {
  const double h = uniform(r, 0.8, 1.0);
  return {{"shelf_0",
           {uniform(r, -0.35, 0.35), uniform(r, -0.2, 0.2)},
           uniform(r, -0.5, 0.5),
           {{{0, h, 0}, {uniform(r, 0.4, 0.7), h, uniform(r, 0.15, 0.22)}}}}};
}

/// Two pieces of one size across the line and `opening` metres between them, its middle beside the line.
std::vector<Piece> two_sides(const std::string& name, double opening, double aside, double along,
                             const Vector3d& half) {
  std::vector<Piece> out;
  for (const int side : {-1, 1})
    out.push_back({name + (side < 0 ? "_0" : "_1"),
                   {aside + side * (opening / 2 + half.x()), along},
                   0,
                   {{{0, half.y(), 0}, half}}});
  return out;
}

std::vector<Piece> gap(std::mt19937_64& r) {
  const double opening = uniform(r, 0.9, 1.1), side = chance(r, 0.5) ? 1 : -1;
  return two_sides("cabinet", opening, side * uniform(r, 0.55, 0.8), uniform(r, -0.2, 0.2),
                   {uniform(r, 0.5, 0.7), uniform(r, 0.4, 0.6), uniform(r, 0.2, 0.3)});
}

std::vector<Piece> wall(std::mt19937_64& r) {
  const double opening = uniform(r, 0.9, 1.1), side = chance(r, 0.5) ? 1 : -1;
  return two_sides("wall", opening, side * uniform(r, 0.6, 0.9), uniform(r, -0.3, 0.3), {1.5, 1.2, 0.08});
}

std::vector<Piece> pieces_of(int64_t kind, std::mt19937_64& random) {
  constexpr std::array<std::vector<Piece> (*)(std::mt19937_64&), kBlockedKinds.size()> makers = {table, sofa, shelf,
                                                                                                 gap, wall};
  return makers[static_cast<size_t>(kind)](random);
}

/// Somebody who stands (stride 0) or is in a step with the left (1) or the right leg (-1) ahead, facing +Z with the
/// root above the origin.
Clip pose_of(int stride, double rate) {
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.rate = rate;
  clip.rotations = torch::zeros({1, clip.skeleton.size(), 3});
  const auto rotate = [&](int64_t joint, int64_t axis, double by) { clip.rotations[0][joint][axis] = by; };
  rotate(16, 2, -1.25);  // arms hang
  rotate(17, 2, 1.25);
  if (stride != 0) {
    const int64_t ahead = stride > 0 ? 1 : 2, behind = 3 - ahead;
    rotate(ahead, 0, -0.4);
    rotate(ahead + 3, 0, 0.1);
    rotate(behind, 0, 0.25);
    rotate(behind + 3, 0, 0.35);
    rotate(behind + 6, 0, 0.2);
    rotate(16, 1, stride > 0 ? 0.3 : -0.3);  // the arm beside the leg behind goes ahead
    rotate(17, 1, stride > 0 ? 0.3 : -0.3);
  }
  clip.trans = torch::zeros({1, 3});
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  const double low = std::min(clip.joints[0][10][1].item<double>(), clip.joints[0][11][1].item<double>());
  const Tensor root = clip.joints[0][0];
  return transformed(clip, {0, {-root[0].item<double>(), kSole - low, -root[2].item<double>()}});
}

/// A draw of the key poses: straight on from one to the other along +Z.
Clip draw_ends(int64_t frames, double rate, std::mt19937_64& random) {
  const double distance = uniform(random, kLeastDistance, kMostDistance);
  std::array<Clip, 2> poses;
  for (const size_t end : {0, 1}) {
    const int stride = uniform_int(random, -1, 1);
    const double yaw = stride == 0 ? uniform(random, -1.2, 1.2) : uniform(random, -0.4, 0.4);
    poses[end] = transformed(pose_of(stride, rate), {yaw, {0, 0, (end == 0 ? -0.5 : 0.5) * distance}});
  }
  Clip both = poses[0];
  const auto repeated = [&](const Tensor& first, const Tensor& last) {
    std::vector<int64_t> counts(static_cast<size_t>(first.dim()), 1);
    counts[0] = frames - 1;
    return torch::cat({first.repeat(counts), last});
  };
  both.rotations = repeated(poses[0].rotations, poses[1].rotations);
  both.trans = repeated(poses[0].trans, poses[1].trans);
  both.joints = repeated(poses[0].joints, poses[1].joints);
  return interpolate_linear(both, {0, frames - 1});
}

/// Metres of the shortest detour with enough clearance, if there is one.
std::optional<double> detour_length(const Scene& scene, const Clip& ends) {
  const FreeSpace floor = free_space(obstacles_of(scene));
  const Tensor root = ends.root_path();
  const auto place = [&](int64_t t) { return Vector2d(root[t][0].item<double>(), root[t][2].item<double>()); };
  const Vector2d from = place(0), to = place(ends.frames() - 1);
  const auto path = find_path(floor, from, to, kClear);
  if (!path) return {};
  for (const Vector2d& p : path->points)
    if ((p - from).norm() > kEndsNear && (p - to).norm() > kEndsNear && floor.at(p) < kClear - 0.03) return {};
  return path->total();
}

/// The room with furniture on one side (1) or mirrored (-1), if it is as it should be.
std::optional<BlockedRoom> room_of(const Clip& ends, const std::vector<Piece>& pieces, int64_t kind, int side) {
  BlockedRoom out{kBlockedKinds[static_cast<size_t>(kind)], kind, ends, floor_scene(), 0};
  for (const Piece& piece : pieces) out.scene.meshes.push_back(mesh_of(piece, side));
  const CollisionMeter meter(builtin_body(), out.scene);
  if (meter.near_frames(frames_at(ends, {0, ends.frames() - 1}), kFree).any().item<bool>()) return {};
  if (meter.measure(ends, {kNoTolerance}).front().depth.max().item<double>() < kBlocked) return {};
  const auto length = detour_length(out.scene, ends);
  if (!length || *length > kBriskWalk * ends.seconds()) return {};
  out.detour = *length;
  return out;
}

/// The room moved as a whole.
BlockedRoom moved(BlockedRoom room, const GroundTransform& by) {
  room.ends = transformed(room.ends, by);
  const auto c = static_cast<float>(std::cos(by.yaw)), s = static_cast<float>(std::sin(by.yaw));
  for (Mesh& mesh : room.scene.meshes) {
    const Tensor v = mesh.vertices, x = v.select(1, 0), z = v.select(1, 2);
    mesh.vertices = torch::stack({c * x + s * z + by.shift.x(), v.select(1, 1), c * z - s * x + by.shift.z()}, 1)
                        .to(torch::kFloat32);
  }
  return room;
}

}  // namespace

std::vector<BlockedRoom> blocked_rooms(int64_t pairs, int64_t frames, double rate, uint64_t seed) {
  const Error too_short("blocked rooms",
                        "a clip of " + std::to_string(frames) + " frames is too short to walk around anything");
  if (kBriskWalk * static_cast<double>(frames - 1) / rate < kLeastDistance) throw too_short;
  std::vector<BlockedRoom> out;
  for (int64_t pair = 0; pair < pairs; ++pair) {
    std::mt19937_64 random(item_seed(seed, static_cast<uint64_t>(pair)));
    const int64_t kind = pair % static_cast<int64_t>(kBlockedKinds.size());
    const size_t before = out.size();
    for (int tries = 0; tries < kTries && out.size() == before; ++tries) {
      const Clip ends = draw_ends(frames, rate, random);
      const std::vector<Piece> pieces = pieces_of(kind, random);
      auto room = room_of(ends, pieces, kind, 1);
      if (!room) continue;
      auto mirrored = room_of(ends, pieces, kind, -1);
      if (!mirrored) continue;
      room->name += " " + std::to_string(pair);
      mirrored->name += " " + std::to_string(pair) + " mirrored";
      const GroundTransform by{uniform(random, -M_PI, M_PI), {uniform(random, -2, 2), 0, uniform(random, -2, 2)}};
      out.push_back(moved(std::move(*room), by));
      out.push_back(moved(std::move(*mirrored), by));
    }
    if (out.size() == before) throw too_short;
  }
  return out;
}

}  // namespace inhabit::inbetween
