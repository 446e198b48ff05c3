#include "inhabit/metrics/collision.h"

#include <ATen/Parallel.h>

#include <set>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/motion/placed_body.h"
#include "inhabit/scene/objects.h"

namespace inhabit {
namespace {

using torch::Tensor;

constexpr float kSkinReach =
    0.3F;  // metres that skin is from the nearest joint at most; beyond it the field says nothing
constexpr double kFinestCell = 0.04, kVerticesPerCorner = 6, kMostCorners = 4e5;  // of the field, by what costs least
constexpr int64_t kFramesTogether = 256;                                          // whose skin is held at once

double mean_over(const Tensor& values, const Tensor& mask) {
  const Tensor used = (mask.defined() ? values.index({mask}) : values).to(torch::kDouble);
  return used.numel() > 0 ? used.mean().item<double>() : 0;
}

}  // namespace

Tensor supporting_skin(const BodyModel& body) {
  // Pelvis, hips (thighs) and spine; elbows and wrists, whose skin is that of forearms and hands.
  const std::set<int64_t> supports = {0, 1, 2, 3, 6, 9, 18, 19, 20, 21};
  const Tensor mover = body.skin_weights.argmax(1);
  Tensor out = torch::zeros({mover.size(0)}, torch::kBool);
  for (int64_t v = 0; v < mover.size(0); ++v) {
    auto joint = mover[v].item<int64_t>();
    while (joint >= kStandardJoints) joint = body.skeleton.parents[static_cast<size_t>(joint)];  // fingers, jaw
    out[v] = supports.count(joint) > 0;
  }
  return out;
}

double Collision::frame_ratio(const Tensor& mask) const { return mean_over(depth > 0, mask); }

double Collision::vertex_ratio(const Tensor& mask) const { return mean_over(vertices, mask); }

double Collision::penetration(const Tensor& mask) const {
  const Tensor used = mask.defined() ? depth.index({mask}) : depth;
  return used.numel() > 0 ? used.max().item<double>() : 0;
}

CollisionMeter::CollisionMeter(const BodyModel& body, const Scene& scene) : body_(&body) {
  const Tensor supporting = supporting_skin(body);
  allowed_ =
      torch::full({supporting.size(0)}, kCollisionDepth, torch::kFloat32).masked_fill(supporting, kSupportedDepth);
  Scene counts;
  counts.name = scene.name;
  counts.points = scene.points;
  for (const Mesh& mesh : scene.meshes)
    if (!is_floor(mesh.name) && mesh.faces.size(0) > 0) counts.meshes.push_back(mesh);
  if (counts.meshes.empty() && (!counts.points.defined() || counts.points.size(0) == 0)) return;
  query_.emplace(counts);
  const Solid& solid = query_->solid();
  boxes_.resize(static_cast<size_t>(solid.bodies));
  for (size_t face = 0; face < solid.faces.size(); ++face)
    for (size_t k = 0; k < 3; ++k) boxes_[static_cast<size_t>(solid.body[face])].extend(solid.corner(face, k));
  if (solid.points.empty()) return;
  boxes_.emplace_back();
  for (const Eigen::Vector3f& point : solid.points) boxes_.back().extend(point);
}

Tensor CollisionMeter::placed(const Clip& clip) const {
  if (!clip.rotations.defined()) throw Error("collisions need a motion with joint rotations");
  // Bones of another length than the body's own leave the root joint where it is.
  return clip.root_path() - shaped_skeleton(*body_, clip.betas).offsets[0];
}

std::optional<DistanceField> CollisionMeter::field_around(const Clip& clip, double margin) const {
  const Tensor trans = placed(clip);
  if (!query_) return {};
  const Tensor joints = joint_positions(shaped_skeleton(*body_, clip.betas), clip.rotations, trans).view({-1, 3}),
               low = std::get<0>(joints.min(0)), high = std::get<0>(joints.max(0));
  Eigen::AlignedBox3f skin(Eigen::Vector3f(Eigen::Map<const Eigen::Vector3f>(low.data_ptr<float>())),
                           Eigen::Vector3f(Eigen::Map<const Eigen::Vector3f>(high.data_ptr<float>()))),
      scene;
  skin.min().array() -= kSkinReach;
  skin.max().array() += kSkinReach;
  for (const Eigen::AlignedBox3f& box : boxes_) scene.extend(box);
  scene.min().array() -= static_cast<float>(margin);
  scene.max().array() += static_cast<float>(margin);
  if (!skin.intersects(scene)) return {};
  const Eigen::AlignedBox3d box = skin.intersection(scene).cast<double>();
  const double vertices = static_cast<double>(clip.frames() * allowed_.size(0)),
               corners = std::clamp(vertices / kVerticesPerCorner, 1e3, kMostCorners);
  return DistanceField(*query_, box, std::max(kFinestCell, std::cbrt(box.volume() / corners)));
}

CollisionMeter::Candidates CollisionMeter::candidates(const Clip& clip, const DistanceField& field,
                                                      float margin) const {
  const Tensor skin_points = inhabit::skin_points(clip, *body_).contiguous();
  const int64_t T = skin_points.size(0), V = skin_points.size(1);
  std::vector<Eigen::AlignedBox3f> grown = boxes_;
  for (Eigen::AlignedBox3f& box : grown) {
    box.min().array() -= margin;
    box.max().array() += margin;
  }
  struct Found {
    int64_t vertex;
    bool inside;
  };
  std::vector<std::vector<Found>> of_frame(static_cast<size_t>(T));
  at::parallel_for(0, T, 1, [&](int64_t begin, int64_t end) {
    std::vector<Eigen::AlignedBox3f> close;
    for (int64_t t = begin; t < end; ++t) {
      const Eigen::Map<const Eigen::Matrix3Xf> points(skin_points.data_ptr<float>() + t * V * 3, 3, V);
      const Eigen::AlignedBox3f person(Eigen::Vector3f(points.rowwise().minCoeff()),
                                       Eigen::Vector3f(points.rowwise().maxCoeff()));
      close.clear();
      for (const Eigen::AlignedBox3f& box : grown)
        if (box.intersects(person)) close.push_back(box);
      if (close.empty()) continue;
      for (int64_t v = 0; v < V; ++v) {
        const Eigen::Vector3f point = points.col(v);
        const auto inside = field.inside(point);
        if (inside == false && (margin == 0 || field.clearance(point) >= margin)) continue;
        if (std::any_of(close.begin(), close.end(), [&](const auto& box) { return box.contains(point); }))
          of_frame[static_cast<size_t>(t)].push_back({v, inside == true});
      }
    }
  });
  int64_t count = 0;
  for (const auto& found : of_frame) count += static_cast<int64_t>(found.size());
  Candidates out{torch::empty({count, 3}), torch::empty({count}, torch::kLong), torch::empty({count}, torch::kLong),
                 torch::empty({count}, torch::kBool)};
  auto* points = out.points.data_ptr<float>();
  auto *frames = out.frames.data_ptr<int64_t>(), *vertices = out.vertices.data_ptr<int64_t>();
  auto* inside = out.inside.data_ptr<bool>();
  for (int64_t t = 0; t < T; ++t)
    for (const Found& found : of_frame[static_cast<size_t>(t)]) {
      points = std::copy_n(skin_points.data_ptr<float>() + (t * V + found.vertex) * 3, 3, points);
      *frames++ = t;
      *vertices++ = found.vertex;
      *inside++ = found.inside;
    }
  return out;
}

Collision CollisionMeter::measure(const Clip& clip) const {
  Collision out;
  out.depth = torch::zeros({clip.frames()});
  out.vertices = torch::zeros({clip.frames()});
  const std::optional<DistanceField> field = field_around(clip, 0);
  if (!field) return out;
  float* deepest = out.depth.data_ptr<float>();
  float* share = out.vertices.data_ptr<float>();
  const float one = 1.F / static_cast<float>(allowed_.size(0));
  for (int64_t first = 0; first < clip.frames(); first += kFramesTogether) {
    const Candidates found =
        candidates(slice(clip, first, std::min(first + kFramesTogether, clip.frames())), *field, 0);
    if (found.frames.numel() == 0) continue;
    const Tensor depths = query_->closest(found.points).distances;
    const float *depth = depths.data_ptr<float>(), *may = allowed_.data_ptr<float>();
    const float* points = found.points.data_ptr<float>();
    const int64_t *frame = found.frames.data_ptr<int64_t>(), *vertex = found.vertices.data_ptr<int64_t>();
    const bool* known = found.inside.data_ptr<bool>();
    std::vector<int64_t> unsure;
    const auto count_in = [&](int64_t i) {
      deepest[first + frame[i]] = std::max(deepest[first + frame[i]], depth[i]);
      share[first + frame[i]] += one;
    };
    for (int64_t i = 0; i < found.frames.numel(); ++i) {
      if (depth[i] <= may[vertex[i]]) continue;
      const auto inside = known[i] ? true : field->inside(Eigen::Map<const Eigen::Vector3f>(points + 3 * i), depth[i]);
      if (inside == true) count_in(i);
      if (!inside) unsure.push_back(i);
    }
    if (unsure.empty()) continue;
    const Tensor inside = query_->inside(found.points.index_select(0, torch::tensor(unsure)));
    for (size_t k = 0; k < unsure.size(); ++k)
      if (inside.data_ptr<bool>()[k]) count_in(unsure[k]);
  }
  return out;
}

Tensor CollisionMeter::near_frames(const Clip& clip, double distance) const {
  Tensor out = torch::zeros({clip.frames()}, torch::kBool);
  const std::optional<DistanceField> field = field_around(clip, distance);
  if (!field) return out;
  const Candidates found = candidates(clip, *field, static_cast<float>(distance));
  if (found.frames.numel() == 0) return out;
  const Tensor close = (query_->signed_distance(found.points) < distance).nonzero().flatten();
  return out.index_fill(0, found.frames.index_select(0, close), true);
}

}  // namespace inhabit
