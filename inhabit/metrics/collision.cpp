#include "inhabit/metrics/collision.h"

#include <ATen/Parallel.h>

#include <functional>
#include <limits>
#include <numeric>
#include <set>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/interruption.h"
#include "inhabit/motion/placed_body.h"
#include "inhabit/scene/objects.h"

namespace inhabit {
namespace {

using torch::Tensor;

constexpr double kCell = 0.1, kMostCells = 1 << 26;  // of the field: metres, coarser where a scene is a city
constexpr int64_t kFramesTogether = 256;             // whose skin is held at once
constexpr std::ptrdiff_t kPatch = 48;                // vertices at most

double mean_over(const Tensor& values, const Tensor& mask) {
  const Tensor used = (mask.defined() ? values.index({mask}) : values).to(torch::kDouble);
  return used.numel() > 0 ? used.mean().item<double>() : 0;
}

/// The skin's vertices by where they are at rest, halved until kPatch and less are together.
std::vector<std::vector<int64_t>> patches_of(const BodyModel& body) {
  const Tensor rest = body.template_vertices.to(torch::kFloat32).contiguous();
  const auto* at = rest.data_ptr<float>();
  std::vector<int64_t> vertices(static_cast<size_t>(rest.size(0)));
  std::iota(vertices.begin(), vertices.end(), 0);
  std::vector<std::vector<int64_t>> out;
  using Place = std::vector<int64_t>::iterator;
  const std::function<void(Place, Place)> split = [&](Place begin, Place end) {
    if (end - begin <= kPatch) {
      out.emplace_back(begin, end);
      return;
    }
    Eigen::AlignedBox3f box;
    for (Place v = begin; v != end; ++v) box.extend(Eigen::Map<const Eigen::Vector3f>(at + 3 * *v));
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const Place middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, [&](int64_t a, int64_t b) { return at[3 * a + axis] < at[3 * b + axis]; });
    split(begin, middle);
    split(middle, end);
  };
  split(vertices.begin(), vertices.end());
  return out;
}

}  // namespace

Tensor supporting_skin(const BodyModel& body) {
  // Pelvis, hips (thighs) and spine; elbows and wrists, whose skin is that of forearms and hands.
  const std::set<int64_t> supports = {0, 1, 2, 3, 6, 9, 18, 19, 20, 21};
  const Tensor mover = body.skin_weights.argmax(1).contiguous();
  Tensor out = torch::zeros({mover.size(0)}, torch::kBool);
  for (int64_t v = 0; v < mover.size(0); ++v) {
    int64_t joint = mover.data_ptr<int64_t>()[v];
    while (joint >= kStandardJoints) joint = body.skeleton.parents[static_cast<size_t>(joint)];  // fingers, jaw
    out.data_ptr<bool>()[v] = supports.count(joint) > 0;
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
  supporting_ = supporting_skin(body);
  Scene counts;
  counts.name = scene.name;
  counts.points = scene.points;
  for (const Mesh& mesh : scene.meshes)
    if (!is_floor(mesh.name) && mesh.faces.size(0) > 0) {
      counts.meshes.push_back(mesh);
      objects_.push_back(object_of_mesh(mesh.name));
    }
  if (counts.meshes.empty() && (!counts.points.defined() || counts.points.size(0) == 0)) return;
  query_ = std::make_unique<SceneQuery>(counts);
  const Solid& solid = query_->solid();
  boxes_.resize(static_cast<size_t>(solid.bodies));
  for (size_t face = 0; face < solid.faces.size(); ++face)
    for (size_t k = 0; k < 3; ++k) boxes_[static_cast<size_t>(solid.body[face])].extend(solid.corner(face, k));
  if (!solid.points.empty()) {
    boxes_.emplace_back();
    for (const Eigen::Vector3f& point : solid.points) boxes_.back().extend(point);
  }
  Eigen::AlignedBox3f all;
  for (const Eigen::AlignedBox3f& box : boxes_) all.extend(box);
  const Eigen::AlignedBox3d box = all.cast<double>();
  field_.emplace(*query_, box, std::max(kCell, std::cbrt(box.volume() / kMostCells)));
  patches_ = patches_of(body);
}

CollisionMeter::Candidates CollisionMeter::candidates(const Clip& clip, float margin) const {
  // Bones of another length than the body's own leave the root joint where it is.
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
    std::vector<Eigen::AlignedBox3f> close, beside;
    for (int64_t t = begin; t < end; ++t) {
      const Eigen::Map<const Eigen::Matrix3Xf> points(skin_points.data_ptr<float>() + t * V * 3, 3, V);
      const Eigen::AlignedBox3f person(Eigen::Vector3f(points.rowwise().minCoeff()),
                                       Eigen::Vector3f(points.rowwise().maxCoeff()));
      close.clear();
      for (const Eigen::AlignedBox3f& box : grown)
        if (box.intersects(person)) close.push_back(box);
      if (close.empty()) continue;
      for (const std::vector<int64_t>& patch : patches_) {
        Eigen::AlignedBox3f around;
        for (const int64_t v : patch) around.extend(points.col(v));
        beside.clear();
        for (const Eigen::AlignedBox3f& box : close)
          if (box.intersects(around)) beside.push_back(box);
        if (beside.empty()) continue;
        const Eigen::Vector3f middle = around.center();
        const float radius = 0.5F * around.diagonal().norm();
        if (field_->clearance(middle) >= radius + margin && field_->inside(middle) == false) continue;
        for (const int64_t v : patch) {
          const Eigen::Vector3f point = points.col(v);
          if (std::none_of(beside.begin(), beside.end(), [&](const auto& box) { return box.contains(point); }))
            continue;
          const auto inside = field_->inside(point);
          if (inside == false && (margin == 0 || field_->clearance(point) >= margin)) continue;
          of_frame[static_cast<size_t>(t)].push_back({v, inside == true});
        }
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

Collision CollisionMeter::measure(const Clip& clip) const { return measure(clip, {CollisionTolerance{}}).front(); }

std::vector<Collision> CollisionMeter::measure(const Clip& clip,
                                               const std::vector<CollisionTolerance>& tolerances) const {
  if (!clip.rotations.defined()) throw Error("collisions need a motion with joint rotations");
  std::vector<Collision> out(tolerances.size());
  for (Collision& collision : out) {
    collision.depth = torch::zeros({clip.frames()});
    collision.vertices = torch::zeros({clip.frames()});
    collision.deepest = torch::zeros({clip.frames(), 3});
  }
  if (!query_) return out;
  const float one = 1.F / static_cast<float>(supporting_.size(0));
  std::vector<std::vector<float>> allow;
  allow.reserve(tolerances.size());
  for (const CollisionTolerance& t : tolerances) allow.push_back(allowed(t));
  std::vector<float> least(static_cast<size_t>(supporting_.size(0)), std::numeric_limits<float>::max());
  for (const std::vector<float>& each : allow)
    for (size_t v = 0; v < least.size(); ++v) least[v] = std::min(least[v], each[v]);
  for (int64_t first = 0; first < clip.frames(); first += kFramesTogether) {
    interruption_point();
    const Candidates found = candidates(slice(clip, first, std::min(first + kFramesTogether, clip.frames())), 0);
    std::vector<int64_t> rows(static_cast<size_t>(found.frames.numel()));
    std::iota(rows.begin(), rows.end(), 0);
    const std::vector<float> depth = depths(found, rows, least);
    const int64_t *frame = found.frames.data_ptr<int64_t>(), *vertex = found.vertices.data_ptr<int64_t>();
    const auto* point = found.points.data_ptr<float>();
    for (size_t i = 0; i < rows.size(); ++i)
      for (size_t k = 0; k < tolerances.size(); ++k) {
        if (depth[i] <= allow[k][static_cast<size_t>(vertex[i])]) continue;
        float& deepest = out[k].depth.data_ptr<float>()[first + frame[i]];
        if (depth[i] > deepest) {
          deepest = depth[i];
          std::copy_n(point + 3 * i, 3, out[k].deepest.data_ptr<float>() + 3 * (first + frame[i]));
        }
        out[k].vertices.data_ptr<float>()[first + frame[i]] += one;
      }
  }
  return out;
}

std::vector<std::string> CollisionMeter::nearest_objects(const Tensor& points) const {
  std::vector<std::string> out(static_cast<size_t>(points.size(0)));
  if (!query_ || out.empty()) return out;
  const Tensor mesh = query_->closest(points).mesh.contiguous();
  for (size_t i = 0; i < out.size(); ++i)
    if (const int64_t m = mesh.data_ptr<int64_t>()[i]; m >= 0) out[i] = objects_[static_cast<size_t>(m)];
  return out;
}

std::vector<float> CollisionMeter::allowed(const CollisionTolerance& tolerance) const {
  std::vector<float> out;
  const bool* supporting = supporting_.data_ptr<bool>();
  for (int64_t v = 0; v < supporting_.size(0); ++v)
    out.push_back(static_cast<float>(supporting[v] ? tolerance.supported : tolerance.other));
  return out;
}

std::vector<float> CollisionMeter::depths(const Candidates& found, const std::vector<int64_t>& rows,
                                          const std::vector<float>& least) const {
  std::vector<float> out(rows.size(), 0);
  if (rows.empty()) return out;
  const Tensor points = found.points.index_select(0, torch::tensor(rows)),
               distances = query_->closest(points).distances;
  const float *depth = distances.data_ptr<float>(), *point = points.data_ptr<float>();
  const bool* known = found.inside.data_ptr<bool>();
  const int64_t* vertex = found.vertices.data_ptr<int64_t>();
  std::vector<int64_t> unsure;
  for (size_t i = 0; i < rows.size(); ++i) {
    if (depth[i] <= least[static_cast<size_t>(vertex[rows[i]])]) continue;
    const auto inside =
        known[rows[i]] ? true : field_->inside(Eigen::Map<const Eigen::Vector3f>(point + 3 * i), depth[i]);
    if (inside == true) out[i] = depth[i];
    if (!inside) unsure.push_back(static_cast<int64_t>(i));
  }
  if (unsure.empty()) return out;
  const Tensor inside = query_->inside(points.index_select(0, torch::tensor(unsure)));
  for (size_t k = 0; k < unsure.size(); ++k)
    if (inside.data_ptr<bool>()[k]) out[static_cast<size_t>(unsure[k])] = depth[unsure[k]];
  return out;
}

Tensor CollisionMeter::colliding_frames(const Clip& clip, const CollisionTolerance& tolerance) const {
  if (!clip.rotations.defined()) throw Error("collisions need a motion with joint rotations");
  Tensor out = torch::zeros({clip.frames()}, torch::kBool);
  if (!query_) return out;
  const std::vector<float> least = allowed(tolerance);
  bool* collides = out.data_ptr<bool>();
  for (int64_t first = 0; first < clip.frames(); first += kFramesTogether) {
    interruption_point();
    const Candidates found = candidates(slice(clip, first, std::min(first + kFramesTogether, clip.frames())), 0);
    const int64_t *frame = found.frames.data_ptr<int64_t>(), *vertex = found.vertices.data_ptr<int64_t>();
    const bool* known = found.inside.data_ptr<bool>();
    const auto mark = [&](const std::vector<int64_t>& rows) {
      const std::vector<float> depth = depths(found, rows, least);
      for (size_t i = 0; i < rows.size(); ++i)
        if (depth[i] > 0) collides[first + frame[rows[i]]] = true;
    };
    // The deepest by the field, whose cells round edges off, where it does not tell for certain.
    std::vector<int64_t> deepest, others;
    double most = 0;
    for (int64_t i = 0; i < found.frames.numel(); ++i) {
      if (collides[first + frame[i]]) continue;
      const Eigen::Map<const Eigen::Vector3f> point(found.points.data_ptr<float>() + 3 * i);
      const float free = least[static_cast<size_t>(vertex[i])];
      if (known[i] && field_->clearance(point) > free) {
        collides[first + frame[i]] = true;
        continue;
      }
      const double excess = -field_->distance(point.cast<double>()) - static_cast<double>(free);
      const bool new_frame = deepest.empty() || frame[i] != frame[deepest.back()];
      if (new_frame) deepest.push_back(i);
      if (!new_frame && excess <= most) continue;
      deepest.back() = i;
      most = excess;
    }
    std::erase_if(deepest, [&](int64_t i) { return collides[first + frame[i]]; });
    mark(deepest);
    for (int64_t i = 0; i < found.frames.numel(); ++i)
      if (!collides[first + frame[i]]) others.push_back(i);
    mark(others);
  }
  return out;
}

Tensor CollisionMeter::near_frames(const Clip& clip, double distance) const {
  Tensor out = torch::zeros({clip.frames()}, torch::kBool);
  if (!clip.rotations.defined()) throw Error("collisions need a motion with joint rotations");
  if (!query_) return out;
  const Candidates found = candidates(clip, static_cast<float>(distance));
  if (found.frames.numel() == 0) return out;
  const Tensor close = (query_->signed_distance(found.points) < distance).nonzero().flatten();
  return out.index_fill(0, found.frames.index_select(0, close), true);
}

}  // namespace inhabit
