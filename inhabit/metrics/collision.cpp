#include "inhabit/metrics/collision.h"

#include <set>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"
#include "inhabit/metrics/penetration.h"

namespace inhabit {
namespace {

using torch::Tensor;

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
  for (const Mesh& mesh : scene.meshes) {
    const std::string name = object_of_mesh(mesh.name);
    if (name != "floor" && name != "rug" && mesh.faces.size(0) > 0) counts.meshes.push_back(mesh);
  }
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

CollisionMeter::Candidates CollisionMeter::candidates(const Clip& clip, float margin) const {
  if (!clip.rotations.defined()) throw Error("collisions need a motion with joint rotations");
  // Bones of another length than the body's own leave the root joint where it is.
  const Tensor trans = clip.root_path() - shaped_skeleton(*body_, clip.betas).offsets[0];
  const Tensor skin_points = skin(*body_, clip.betas, axis_angle_to_matrix(clip.rotations), trans).contiguous();
  const int64_t T = skin_points.size(0), V = skin_points.size(1);
  const Tensor low = std::get<0>(skin_points.min(1)), high = std::get<0>(skin_points.max(1));
  std::vector<Eigen::AlignedBox3f> grown = boxes_, close;
  for (Eigen::AlignedBox3f& box : grown) {
    box.min().array() -= margin;
    box.max().array() += margin;
  }
  std::vector<float> points;
  std::vector<int64_t> frames, vertices;
  using Point = Eigen::Map<const Eigen::Vector3f>;
  for (int64_t t = 0; t < T; ++t) {
    const Eigen::AlignedBox3f person(Eigen::Vector3f(Point(low.data_ptr<float>() + 3 * t)),
                                     Eigen::Vector3f(Point(high.data_ptr<float>() + 3 * t)));
    close.clear();
    for (const Eigen::AlignedBox3f& box : grown)
      if (box.intersects(person)) close.push_back(box);
    if (close.empty()) continue;
    const float* p = skin_points.data_ptr<float>() + t * V * 3;
    for (int64_t v = 0; v < V; ++v, p += 3) {
      const Eigen::Vector3f point = Point(p);
      const bool in = std::any_of(close.begin(), close.end(), [&](const auto& box) { return box.contains(point); });
      if (!in) continue;
      points.insert(points.end(), p, p + 3);
      frames.push_back(t);
      vertices.push_back(v);
    }
  }
  const auto count = static_cast<int64_t>(frames.size());
  const auto numbers = [&] { return torch::empty({count}, torch::kLong); };
  Candidates out{torch::empty({count, 3}), numbers(), numbers()};
  std::copy(points.begin(), points.end(), out.points.data_ptr<float>());
  std::copy(frames.begin(), frames.end(), out.frames.data_ptr<int64_t>());
  std::copy(vertices.begin(), vertices.end(), out.vertices.data_ptr<int64_t>());
  return out;
}

Collision CollisionMeter::measure(const Clip& clip) const {
  Collision out;
  out.depth = torch::zeros({clip.frames()});
  out.vertices = torch::zeros({clip.frames()});
  const Candidates found = candidates(clip, 0);
  if (found.frames.numel() == 0) return out;
  const Tensor inside = query_->inside(found.points).nonzero().flatten();
  if (inside.numel() == 0) return out;
  const Tensor frames = found.frames.index_select(0, inside),
               allowed = allowed_.index_select(0, found.vertices.index_select(0, inside)),
               depths = query_->closest(found.points.index_select(0, inside)).distances;
  float* deepest = out.depth.data_ptr<float>();
  float* share = out.vertices.data_ptr<float>();
  const float *depth = depths.data_ptr<float>(), *may = allowed.data_ptr<float>();
  const int64_t* frame = frames.data_ptr<int64_t>();
  const float one = 1.F / static_cast<float>(allowed_.size(0));
  for (int64_t i = 0; i < frames.numel(); ++i) {
    if (depth[i] <= may[i]) continue;
    deepest[frame[i]] = std::max(deepest[frame[i]], depth[i]);
    share[frame[i]] += one;
  }
  return out;
}

Tensor CollisionMeter::near_frames(const Clip& clip, double distance) const {
  Tensor out = torch::zeros({clip.frames()}, torch::kBool);
  const Candidates found = candidates(clip, static_cast<float>(distance));
  if (found.frames.numel() == 0) return out;
  const Tensor close = (query_->signed_distance(found.points) < distance).nonzero().flatten();
  return out.index_fill(0, found.frames.index_select(0, close), true);
}

}  // namespace inhabit
