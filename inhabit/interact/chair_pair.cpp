#include "inhabit/interact/chair_pair.h"

#include <algorithm>
#include <cmath>

#include "inhabit/scene/objects.h"
#include "inhabit/scene/point_rows.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;

constexpr double kFarthestPlace = 0.12;  // metres from where a hand's place should be to a surface
constexpr double kOnSurface = 0.03;      // metres: what a hand touches
constexpr double kFacesAlike = 0.8;      // cosine between normals
constexpr double kClearOfThigh = 0.14;   // metres from its bone
constexpr double kHip = 0.2;             // metres from the person's middle to an edge of the seat

Vector3d row_at(const torch::Tensor& rows, size_t i) {
  const float* p = rows.data_ptr<float>() + 3 * i;
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

Mesh moved_mesh(const Mesh& mesh, const Eigen::Isometry3d& motion) {
  torch::Tensor rotation = torch::empty({3, 3}), shift = torch::empty({3});
  for (int r = 0; r < 3; ++r) {
    shift[r] = motion.translation()[r];
    for (int c = 0; c < 3; ++c) rotation[r][c] = motion.linear()(r, c);
  }
  Mesh out = mesh;
  out.vertices = torch::matmul(mesh.vertices, rotation.t()) + shift;
  return out;
}

/// How far the seat goes on from below the person along an axis: until its height changes by more than 4 cm for 6 cm.
double reach_of(const Chair& chair, const SceneQuery& surface, const Vector3d& axis) {
  constexpr int kSteps = 320, kGap = 24;
  constexpr double kStep = 0.0025, kFromAbove = 0.5;
  std::vector<Vector3d> from;
  from.reserve(kSteps);
  for (int i = 0; i < kSteps; ++i)
    from.push_back(chair.frame * Vector3d(axis * (i * kStep) + Vector3d(0, chair.seat_height + kFromAbove, 0)));
  const RayHits hits = surface.cast(point_rows(from), torch::tensor({0.F, -1.F, 0.F}).expand({kSteps, 3}).contiguous());
  double reach = 0;
  for (int i = 0, gap = 0; i < kSteps && gap < kGap; ++i) {
    const bool level = hits.hit[i].item<bool>() && std::abs(hits.distances[i].item<double>() - kFromAbove) < 0.04;
    gap = level ? 0 : gap + 1;
    if (level) reach = i * kStep;
  }
  return reach;
}

/// The seat's height right below the person, where that is near to `height`: cushions are not level.
double height_below(const SceneQuery& surface, const Eigen::Isometry3d& frame, double height) {
  const RayHits hits =
      surface.cast(point_rows({frame * Vector3d(0, height + 0.2, 0)}), torch::tensor({0.F, -1.F, 0.F}).view({1, 3}));
  if (!hits.hit[0].item<bool>()) return height;
  const double found = height + 0.2 - hits.distances[0].item<double>();
  return std::abs(found - height) < 0.06 ? found : height;
}

/// A point of a surface that faces `normal`.
struct FacingPlace {
  Vector3d point = Vector3d::Zero(), normal = Vector3d::Zero();
  bool found = false;
};

/// The nearest places of the new chair, or those met from outside along the old normal.
std::vector<FacingPlace> places_near(const SceneQuery& surface, const std::vector<Vector3d>& points,
                                     const Vector3d& normal, bool along) {
  std::vector<FacingPlace> out(points.size());
  torch::Tensor found, normals;
  if (along) {
    std::vector<Vector3d> from = points;
    for (Vector3d& p : from) p += kFarthestPlace * normal;
    const RayHits hits = surface.cast(point_rows(from), point_rows(std::vector<Vector3d>(points.size(), -normal)));
    found = hits.points.contiguous(), normals = hits.normals.contiguous();
    for (size_t i = 0; i < out.size(); ++i) out[i].found = hits.hit[static_cast<int64_t>(i)].item<bool>();
  } else {
    const ClosestPoints closest = surface.closest(point_rows(points));
    found = closest.points.contiguous(), normals = closest.normals.contiguous();
    for (FacingPlace& place : out) place.found = true;
  }
  for (size_t i = 0; i < out.size(); ++i) {
    out[i].point = row_at(found, i);
    out[i].normal = row_at(normals, i);
    if (out[i].normal.dot(normal) < 0) out[i].normal = -out[i].normal;
    out[i].found =
        out[i].found && out[i].normal.dot(normal) >= kFacesAlike && (out[i].point - points[i]).norm() <= kFarthestPlace;
  }
  return out;
}

double level_distance(const Vector3d& a, const Vector3d& b) { return std::hypot(a.x() - b.x(), a.z() - b.z()); }

/// Metres from a place to the nearer thigh's bone, hips `rise` higher than they were.
double off_thighs(const TouchingBody& body, const Vector3d& place, double rise) {
  double nearest = 1e9;
  for (size_t side = 0; side < 2; ++side) {
    const Vector3d hip = body.hip[side] + Vector3d(0, rise, 0), along = body.knee[side] - hip;
    const double along_bone = std::clamp((place - hip).dot(along) / std::max(along.squaredNorm(), 1e-9), 0.0, 1.0);
    nearest = std::min(nearest, (place - hip - along_bone * along).norm());
  }
  return nearest;
}

}  // namespace

SeatExtent seat_extent(const Chair& chair) {
  Scene alone;
  alone.meshes = {chair.mesh};
  const SceneQuery surface(alone);
  return {reach_of(chair, surface, Vector3d::UnitZ()), -reach_of(chair, surface, -Vector3d::UnitZ()),
          reach_of(chair, surface, Vector3d::UnitX()), -reach_of(chair, surface, -Vector3d::UnitX())};
}

Vector3d corresponding(const Vector3d& place, const SeatExtent& from, double from_height, const SeatExtent& to,
                       double to_height, const Correspondence& how) {
  Vector3d out = place;
  if (how.from_side)
    out.x() += place.x() > 0.5 * (from.left + from.right) ? to.left - from.left : to.right - from.right;
  out.y() = place.y() < from_height ? place.y() * to_height / from_height : to_height + place.y() - from_height;
  out.z() += how.from_rear ? to.rear - from.rear : to.front - from.front;
  return out;
}

ChairPair pair_chairs(const Chair& old, const Scene& chairs, const std::string& name) {
  ChairPair out{old, find_chair(chairs, name), {}, {}, {}, nullptr, nullptr};
  out.old_seat = seat_extent(out.old);
  const SeatExtent own = seat_extent(out.fresh);
  // Where on the new chair the person is to be, in its own frame.
  const double half = 0.5 * (own.left - own.right), old_half = 0.5 * (out.old_seat.left - out.old_seat.right);
  const double aside = -0.5 * (out.old_seat.left + out.old_seat.right) / std::max(old_half, 1e-3);
  const double most = half - std::min(kHip, half);
  const Vector3d person(0.5 * (own.left + own.right) + std::clamp(aside * half, -most, most), 0,
                        own.front - out.old_seat.front);
  const Eigen::Isometry3d place = out.old.frame * Eigen::Translation3d(-person) * out.fresh.frame.inverse();
  for (const Mesh& mesh : chairs.meshes) {
    if (object_of_mesh(mesh.name) != name) continue;
    Mesh copy = moved_mesh(mesh, place);
    copy.name = out.old.name + mesh.name.substr(name.size());
    out.fresh_scene.meshes.push_back(copy);
  }
  out.fresh.name = out.old.name;
  out.fresh.mesh = moved_mesh(out.fresh.mesh, place);
  out.fresh.mesh.name = out.old.name;
  out.fresh.frame = out.old.frame;
  Scene alone;
  alone.meshes = {out.old.mesh};
  out.old_surface = std::make_unique<SceneQuery>(alone);
  out.fresh_surface = std::make_unique<SceneQuery>(out.fresh_scene);
  out.fresh.seat_height = height_below(*out.fresh_surface, out.fresh.frame, out.fresh.seat_height);
  out.fresh_seat = seat_extent(out.fresh);
  return out;
}

std::optional<CarriedTouch> carry_touch(const ChairPair& chairs, const std::vector<Vector3d>& points,
                                        const TouchingBody& body) {
  const ClosestPoints before = chairs.old_surface->closest(point_rows(points));
  if (before.distances.max().item<double>() > kOnSurface) return std::nullopt;
  const size_t middle = points.size() / 2;
  Vector3d normal = row_at(before.normals.contiguous(), middle);
  if (normal.dot(body.wrist - points[middle]) < 0) normal = -normal;
  std::optional<CarriedTouch> best;
  double least = 1e9;
  for (int which = 0; which < 8; ++which) {
    const Correspondence how{(which & 1) != 0, (which & 2) != 0};
    std::vector<Vector3d> wanted;
    wanted.reserve(points.size());
    for (const Vector3d& point : points)
      wanted.push_back(chairs.fresh.frame * corresponding(chairs.old.frame.inverse() * point, chairs.old_seat,
                                                          chairs.old.seat_height, chairs.fresh_seat,
                                                          chairs.fresh.seat_height, how));
    const std::vector<FacingPlace> found = places_near(*chairs.fresh_surface, wanted, normal, (which & 4) != 0);
    if (!std::all_of(found.begin(), found.end(), [](const FacingPlace& p) { return p.found; })) continue;
    if (level_distance(found[middle].point, points[middle]) > kFarthestPlace) continue;
    const double clear = off_thighs(body, points[middle], 0);
    if (off_thighs(body, found[middle].point, chairs.rise()) < std::min(clear, kClearOfThigh) - 0.02) continue;
    // Alike to where it was seen from the person, unless an edge is in between.
    const double cost =
        (found[middle].point - wanted[middle]).norm() + 0.15 * (1 - found[middle].normal.dot(normal)) + 0.001 * which;
    if (cost >= least) continue;
    least = cost;
    best = CarriedTouch{{}, Eigen::Quaterniond::FromTwoVectors(normal, found[middle].normal)};
    for (const FacingPlace& place : found) best->points.push_back(place.point);
  }
  return best;
}

}  // namespace inhabit::interact
