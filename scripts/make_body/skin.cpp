#include "skin.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "decimate.h"
#include "inhabit/body/proportions.h"
#include "inhabit/math/smooth_step.h"
#include "surface.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;
using JointWeights = std::array<double, kStandardJoints>;

/// Rises smoothly from 0 at x = -1 to 1 at x = 1.
double rise(double x) { return smooth_step(0.5 * (x + 1)); }

/// Moves the fraction `part` of a joint's weight on to its child.
void pass_on(JointWeights& w, int from, int to, double part) {
  w[to] += part * w[from];
  w[from] *= 1 - part;
}

/// Which joints move the skin at `p`: the weight starts at the pelvis and is handed on at each joint, over a stretch as
/// wide as the flesh there.
JointWeights weights_at(const Vector3d& p, const std::array<Vector3d, kStandardJoints>& rest) {
  JointWeights w{};
  w[0] = 1;
  pass_on(w, 0, 3, rise((p.y() - rest[3].y()) / 0.070));
  pass_on(w, 3, 6, rise((p.y() - rest[6].y()) / 0.065));
  pass_on(w, 6, 9, rise((p.y() - rest[9].y()) / 0.055));
  const double x = std::abs(p.x());
  pass_on(w, 9, 12, rise((p.y() - rest[12].y()) / 0.045) * rise((0.090 - x) / 0.030));
  // The head begins along a slope from under the chin to the nape.
  pass_on(w, 12, 15, rise((p.y() + 0.45 * p.z() - 0.572) / 0.030));

  const int side = p.x() >= 0 ? 0 : 1;
  const double above_armpit = rise((p.y() - 0.345) / 0.055);
  pass_on(w, 9, 13 + side, rise((x - 0.085) / 0.055) * above_armpit);
  pass_on(w, 13 + side, 16 + side, rise((x - rest[16].x() + 0.004) / 0.058) * above_armpit);
  pass_on(w, 16 + side, 18 + side, rise((x - rest[18].x()) / 0.055));
  pass_on(w, 18 + side, 20 + side, rise((x - rest[20].x()) / 0.030));

  // The hip's fold runs from the groin up to the side of the pelvis.
  const Vector3d fold = Vector3d(0.60, -0.80, 0);
  const Vector3d from_hip = Vector3d(x, p.y(), p.z()) - rest[1];
  const double leg = rise(fold.dot(from_hip) / 0.070);
  // Near the middle both legs share the skin.
  const double own = rise((x - 0.012) / 0.040), other = rise((-x - 0.012) / 0.040);
  const double pelvis = w[0];
  w[1 + side] = pelvis * leg * own;
  w[2 - side] = pelvis * leg * other;
  w[0] = pelvis - w[1] - w[2];
  pass_on(w, 1 + side, 4 + side, rise((rest[4].y() - p.y()) / 0.065));
  pass_on(w, 4 + side, 7 + side, rise((rest[7].y() + 0.005 - p.y()) / 0.035));
  pass_on(w, 7 + side, 10 + side, rise((p.z() - rest[10].z()) / 0.030));
  return w;
}

}  // namespace

TriangleSurface builtin_skin() {
  // One half, mirrored: cells small enough for thumbs and noses, then the flat parts made coarse.
  TriangleSurface half =
      polygonise(builtin_surface_distance, Vector3d(0, -0.98, -0.17), Vector3d(0.94, 0.80, 0.20), 0.010);
  smooth(half, 2);
  half = decimate(half, 1900, [](const Vector3d& p) {
    if (p.x() > 0.70) return 12.0;                                // hands
    if (p.y() > 0.53) return p.z() > 0.05 ? 14.0 : 4.0;           // face, head
    if (p.y() < -0.86) return 4.0;                                // feet
    if (p.x() > 0.12 && p.x() < 0.25 && p.y() > 0.3) return 3.0;  // shoulders and
    if (p.y() < 0.02 && p.y() > -0.2) return 2.0;                 // hips bend most
    return 1.0;
  });
  relax(builtin_surface_distance, half, 3);
  return mirrored(half);
}

torch::Tensor builtin_skin_weights(const TriangleSurface& skin) {
  const auto rest = builtin_rest_joints();
  const size_t n = skin.vertices.size();
  std::vector<JointWeights> weights(n);
  for (size_t v = 0; v < n; ++v) weights[v] = weights_at(skin.vertices[v], rest);
  // A little smoothing along the skin, so that no fold of the weights falls between two vertices.
  for (int round = 0; round < 2; ++round) {
    std::vector<JointWeights> sum(n, JointWeights{});
    std::vector<double> count(n, 0);
    for (const auto& f : skin.faces)
      for (int i = 0; i < 3; ++i) {
        const int a = f[i], b = f[(i + 1) % 3];
        count[a] += 1;
        for (int j = 0; j < kStandardJoints; ++j) sum[a][j] += weights[b][j];
      }
    for (size_t v = 0; v < n; ++v)
      for (int j = 0; j < kStandardJoints; ++j) weights[v][j] = 0.5 * weights[v][j] + 0.5 * sum[v][j] / count[v];
  }
  torch::Tensor out = torch::zeros({static_cast<int64_t>(n), kStandardJoints});
  auto a = out.accessor<float, 2>();
  for (size_t v = 0; v < n; ++v) {
    std::array<int, kStandardJoints> order;
    for (int j = 0; j < kStandardJoints; ++j) order[j] = j;
    std::partial_sort(order.begin(), order.begin() + 4, order.end(),
                      [&](int i, int j) { return weights[v][i] > weights[v][j]; });
    double total = 0;
    for (int k = 0; k < 4; ++k) total += weights[v][order[k]] > 0.004 ? weights[v][order[k]] : 0;
    for (int k = 0; k < 4; ++k)
      if (weights[v][order[k]] > 0.004)
        a[static_cast<int64_t>(v)][order[k]] = static_cast<float>(weights[v][order[k]] / total);
  }
  return out;
}

torch::Tensor builtin_shape_directions(const TriangleSurface& skin, const torch::Tensor& weights) {
  const auto rest = builtin_rest_joints();
  // The joint at the far end of each joint's bone; -1 where the flesh is carried along as a whole.
  constexpr std::array<int, kStandardJoints> kFarEnd = {3,  4,  5,  6,  7,  8,  9,  -1, -1, 12, -1,
                                                        -1, 15, 16, 17, -1, 18, 19, 20, 21, -1, -1};
  // How much thicker flesh grows around each bone with a unit of girth.
  constexpr std::array<double, kStandardJoints> kGrowth = {0.12, 0.11, 0.11,  0.13,  0.08, 0.08, 0.13, 0.03,
                                                           0.03, 0.11, 0.015, 0.015, 0.07, 0.09, 0.09, 0.02,
                                                           0.10, 0.10, 0.08,  0.08,  0.02, 0.02};
  std::array<std::array<Vector3d, kStandardJoints>, kBuiltinBetas> joint_moves;
  for (int b = 0; b < kBuiltinBetas; ++b) joint_moves[b] = builtin_joint_direction(static_cast<BuiltinBeta>(b));

  const int64_t n = static_cast<int64_t>(skin.vertices.size());
  torch::Tensor out = torch::zeros({n, 3, static_cast<int64_t>(kBuiltinBetas)});
  auto o = out.accessor<float, 3>();
  auto w = weights.accessor<float, 2>();
  for (int64_t v = 0; v < n; ++v) {
    const Vector3d& p = skin.vertices[v];
    std::array<Vector3d, kBuiltinBetas> move;
    move.fill(Vector3d::Zero());
    double trunk = 0;
    for (int j = 0; j < kStandardJoints; ++j) {
      const double weight = w[v][j];
      if (weight == 0) continue;
      const int end = kFarEnd[j];
      const Vector3d bone = end < 0 ? Vector3d::Zero() : Vector3d(rest[end] - rest[j]);
      const double t = end < 0 ? 0 : std::clamp((p - rest[j]).dot(bone) / bone.squaredNorm(), 0.0, 1.0);
      for (int b : {kLegs, kArms, kTorso, kShoulders, kHips}) {
        const Vector3d& here = joint_moves[b][j];
        // The pelvis stretches along the spine only: its other children pull their own flesh.
        move[b] += weight * (end < 0 ? here : Vector3d(here + t * (joint_moves[b][end] - here)));
      }
      const bool in_trunk = j == 0 || j == 3 || j == 6 || j == 9;
      if (in_trunk) trunk += weight;
      if (j == 0 || j == 3) move[kHips].x() += weight * 0.06 * p.x() * (j == 0 ? 1.0 : 0.35);
      if (j == 6 || j == 9) move[kShoulders].x() += weight * 0.045 * p.x() * (j == 9 ? 1.0 : 0.6);

      // Away from the bone, across it only, so that lengths and the flat sole stay.
      const bool in_arm = j == 13 || j == 14 || j >= 16;
      const Vector3d axis = in_trunk ? Vector3d(0, 0, -0.010) : Vector3d(rest[j] + t * bone);
      Vector3d away = p - axis;
      away[in_arm ? 0 : 1] = 0;
      if (!in_arm && !in_trunk && away.x() * p.x() < 0) away.x() *= 0.15;  // thighs must not grow into each other
      move[kGirth] += weight * kGrowth[j] * away;
    }
    move[kStature] = 0.04 * p;
    const double height = std::exp(-std::pow((p.y() - 0.075) / 0.085, 2));
    move[kBelly].z() = 0.025 * trunk * height * rise((p.z() - 0.03) / 0.07);
    move[kBelly].x() = 0.010 * trunk * height * p.x() / 0.14;
    for (int b = 0; b < kBuiltinBetas; ++b)
      for (int i = 0; i < 3; ++i) o[v][i][b] = static_cast<float>(move[b][i]);
  }
  return out;
}

}  // namespace inhabit
