#include "inhabit/inbetween/obstacle_detours.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/rotation.h"
#include "inhabit/math/smooth_step.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/scene/occupancy.h"
#include "inhabit/scene/walk_path.h"

namespace inhabit::inbetween {

using Eigen::Vector2d;
using torch::Tensor;

namespace {

constexpr int64_t kSide = 96;
constexpr double kCell = 0.1;                          // metres
constexpr int kLayers = 15;                            // of cells, around the next height
constexpr double kMiddle = 0.95;                       // metres above the floor
constexpr float kThrough = 0.07F;                      // metres from a cell's middle to a surface that goes through it
const std::vector<double> kMargins = {0.5, 0.4, 0.3};  // metres: clearance of the new one, so that arms pass
constexpr double kHardlyLonger = 1.2;                  // times as long as the shortest, for more clearance
constexpr double kTurning = 15;                        // frames around keys in which the heading comes back to theirs

/// Clearances of squares [z][x], drawn finer for find_path.
FreeSpace finer(const std::vector<float>& squares) {
  FreeSpace out;
  out.cell = kCell / 2;
  out.nx = out.nz = 2 * static_cast<int>(kSide) - 1;
  out.origin = Vector2d::Constant(-0.5 * kCell * (kSide - 1));
  for (int k = 0; k < out.nz; ++k)
    for (int i = 0; i < out.nx; ++i) {
      const auto at = [&](int di, int dk) { return squares[static_cast<size_t>((k + dk) / 2 * kSide + (i + di) / 2)]; };
      out.clearance.push_back((at(0, 0) + at(i % 2, 0) + at(0, k % 2) + at(i % 2, k % 2)) / 4);
    }
  return out;
}

/// Distance from every place of the floor to the nearest occupied square, drawn finer for find_path.
FreeSpace clearance_of(const Tensor& floor) {
  const Tensor squares = (floor > 0).to(torch::kUInt8).contiguous();  // [x][z]
  const uint8_t* occupied = squares.data_ptr<uint8_t>();
  const auto reach = static_cast<int>(FreeSpace::kFarthest / kCell);
  const int side = kSide;
  std::vector<float> coarse(kSide * kSide);
  const auto clearance = [&](int x, int z) -> float& {
    return coarse[static_cast<size_t>(z) * kSide + static_cast<size_t>(x)];
  };
  for (int x = 0; x < side; ++x)
    for (int z = 0; z < side; ++z) {
      int nearest = reach * reach;
      for (int i = std::max(0, x - reach); i <= std::min(side - 1, x + reach); ++i)
        for (int k = std::max(0, z - reach); k <= std::min(side - 1, z + reach); ++k)
          if (occupied[i * side + k] != 0) nearest = std::min(nearest, (i - x) * (i - x) + (k - z) * (k - z));
      // From the middle of one square to the edge of the other.
      clearance(x, z) = static_cast<float>(std::sqrt(static_cast<double>(nearest)) * kCell - kCell / 2);
    }
  return finer(coarse);
}

}  // namespace

FreeSpace floor_grid(const std::function<double(const Vector2d&)>& clearance) {
  std::vector<float> squares;
  squares.reserve(kSide * kSide);
  for (int z = 0; z < kSide; ++z)
    for (int x = 0; x < kSide; ++x)
      squares.push_back(static_cast<float>(
          std::min(FreeSpace::kFarthest, clearance(kCell * (Vector2d(x, z) - Vector2d::Constant(0.5 * (kSide - 1)))))));
  return finer(squares);
}

bool line_blocked(const FreeSpace& floor, const Vector2d& from, const Vector2d& to) {
  const double length = (to - from).norm();
  for (double s = kNearKeys; s < length - kNearKeys; s += kCell / 2)
    if (floor.at(from + (to - from) * (s / length)) < kWide) return true;
  return false;
}

std::optional<WalkPath> path_around_obstacles(const FreeSpace& floor, const Vector2d& from, const Vector2d& to,
                                              double longest) {
  return find_roomy_path(floor, from, to, kMargins, {.times = kHardlyLonger, .longest = longest});
}

Tensor scene_floor(const SceneQuery& scene, const Tensor& root, double yaw, double height) {
  const Eigen::Vector3d center(root[0].item<double>(), height + kMiddle, root[2].item<double>());
  const Tensor cells = occupancy_grid(scene.solid(), center, yaw, {{kSide, kLayers, kSide}, kCell});
  return cells.amax(1);
}

std::vector<RootLeg> root_legs(const Tensor& root, const Tensor& groups) {
  const Tensor places = root.to(torch::kFloat32).contiguous(), constrains = groups.to(torch::kFloat32).contiguous(),
               keys = constrains.amax(1).contiguous();
  const auto place = places.accessor<float, 2>(), constraint = constrains.accessor<float, 2>();
  const auto key = keys.accessor<float, 1>();
  const auto ground = [&](int64_t t) { return Vector2d(place[t][0], place[t][2]); };
  const auto has_root = [&](int64_t t) { return constraint[t][kRootTranslationGroup] > 0; };
  std::vector<RootLeg> out;
  int64_t before = -1;
  for (int64_t t = 0; t < root.size(0); ++t) {
    if (key[t] == 0) continue;
    const int64_t from = std::exchange(before, t);
    if (from < 0 || !has_root(from) || !has_root(t)) continue;
    if ((ground(t) - ground(from)).norm() >= 2 * kNearKeys) out.push_back({from, t, ground(from), ground(t)});
  }
  return out;
}

Tensor root_places(const Poses& poses) {
  Tensor out = torch::empty({poses.frames(), 3});
  auto place = out.accessor<float, 2>();
  for (int64_t t = 0; t < poses.frames(); ++t)
    for (int axis = 0; axis < 3; ++axis) place[t][axis] = poses.root(t)[axis];
  return out;
}

Tensor detours_around(const Tensor& floor, const Tensor& root, const Tensor& groups, std::vector<int64_t>* unreached) {
  Tensor detours = torch::zeros({root.size(0), 2});
  auto detour = detours.accessor<float, 2>();
  std::optional<FreeSpace> clearance;
  for (const auto& [from, to, a, b] : root_legs(root, groups)) {
    if (!clearance) clearance = clearance_of(floor);
    const auto known = [&](const Vector2d& p) { return clearance->at(p) > -FreeSpace::kFarthest; };
    if (!known(a) || !known(b) || !line_blocked(*clearance, a, b)) continue;
    const auto found = path_around_obstacles(*clearance, a, b, kQuickest * static_cast<double>(to - from));
    if (!found) {
      if (unreached) unreached->push_back(to);
      continue;
    }
    for (int64_t i = from + 1; i < to; ++i) {
      const double part = static_cast<double>(i - from) / static_cast<double>(to - from);
      const Vector2d aside = found->at(part * found->total()) - (a + part * (b - a));
      detour[i][0] = static_cast<float>(aside.x());
      detour[i][1] = static_cast<float>(aside.y());
    }
  }
  return detours;
}

Tensor detours_of_clip(const Clip& clip, const Tensor& groups, const SceneQuery& scene, double floor,
                       std::vector<int64_t>* unreached) {
  const GroundTransform to_canonical = canonical_transform(clip);
  const Tensor plan = scene_floor(scene, clip.joints[0][0], -to_canonical.yaw, floor);
  const Tensor detours = detours_around(plan, transformed(clip, to_canonical).root_path(), groups, unreached);
  Tensor moves = torch::zeros({clip.frames(), 3});
  moves.select(1, 0).copy_(detours.select(1, 0));
  moves.select(1, 2).copy_(detours.select(1, 1));
  return moves.matmul(yaw_matrix(-to_canonical.yaw).t()).index_select(1, torch::tensor({0, 2})).contiguous();
}

Tensor detours_of_poses(const Poses& keys, const Tensor& groups, const SceneDistances& scene,
                        std::vector<int64_t>* unreached) {
  const Eigen::Vector3f& start = keys.root(0);
  Tensor plan = torch::full({kSide, kSide}, -1.0F);
  auto square = plan.accessor<float, 2>();
  const auto middle = [](int64_t i, int64_t count) {
    return static_cast<float>(kCell * (static_cast<double>(i) - 0.5 * static_cast<double>(count - 1)));
  };
  for (int64_t x = 0; x < kSide; ++x)
    for (int64_t z = 0; z < kSide; ++z)
      for (int64_t y = 0; y < kLayers && square[x][z] < 0; ++y)
        if (scene.distance({start.x() + middle(x, kSide), static_cast<float>(kMiddle) + middle(y, kLayers),
                            start.z() + middle(z, kSide)}) < kThrough)
          square[x][z] = 1;
  const Tensor root = root_places(keys) - torch::tensor({start.x(), start.y(), start.z()});
  return detours_around(plan, root, groups, unreached);
}

std::vector<double> yaws_along(const std::vector<Vector2d>& straight, const Tensor& detours,
                               const std::vector<int64_t>& keys) {
  std::vector<double> yaws(straight.size(), 0);
  const auto offset = detours.accessor<float, 2>();
  const auto place = [&](int64_t t) -> Vector2d {
    return straight[static_cast<size_t>(t)] + Vector2d(offset[t][0], offset[t][1]);
  };
  for (size_t k = 0; k + 1 < keys.size(); ++k) {
    const int64_t from = keys[k], to = keys[k + 1];
    if (to - from < 2 || detours.slice(0, from + 1, to).abs().max().item<double>() == 0) continue;
    const double ahead = inhabit::heading_of(straight[static_cast<size_t>(to)] - straight[static_cast<size_t>(from)]);
    for (int64_t t = from + 1; t < to; ++t) {
      const Vector2d along = place(std::min(to, t + kAlongPath)) - place(std::max(from, t - kAlongPath));
      const double near = static_cast<double>(std::min(t - from, to - t)) / kTurning;
      yaws[static_cast<size_t>(t)] = smooth_step(near) * wrapped(inhabit::heading_of(along) - ahead);
    }
  }
  return yaws;
}

Tensor along_detours(const Tensor& baseline, const Tensor& detours, const Tensor& mask, const Tensor& deviation) {
  Tensor moves = torch::zeros_like(baseline);
  for (const int64_t axis : {0, 2}) {
    const Tensor move = detours.select(2, axis / 2).unsqueeze(1);  // (B, 1, T)
    moves.slice(1, axis, axis + 1).copy_(move);
    moves.slice(1, kJointFeature + axis, kFeatureCount, 3).copy_(move.expand({-1, 22, -1}));
  }
  return baseline + moves / deviation.unsqueeze(1) * (1 - mask);
}

}  // namespace inhabit::inbetween
