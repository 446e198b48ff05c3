#include "inhabit/refine/depth_terms.h"

#include <cmath>

#include "inhabit/scene/point_rows.h"
#include "inhabit/scene/triangle.h"

namespace inhabit::refine {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kPosed = kStandardJoints - 1;  // joints whose rotations shape the skin

std::vector<Vector3d> rows_of(const torch::Tensor& points) {
  const torch::Tensor p = points.to(torch::kCPU, torch::kDouble).contiguous();
  std::vector<Vector3d> out(static_cast<size_t>(p.size(0)));
  const double* x = p.data_ptr<double>();
  for (Vector3d& v : out) v = Vector3d(x[0], x[1], x[2]), x += 3;
  return out;
}

std::array<double, 3> barycentric(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d00 = ab.dot(ab), d01 = ab.dot(ac), d11 = ac.dot(ac), d20 = ap.dot(ab), d21 = ap.dot(ac);
  const double area = d00 * d11 - d01 * d01;
  if (area <= 1e-20 * d00 * d11 || !(area > 0)) {  // no area: the nearest corner
    const std::array<double, 3> away{ap.squaredNorm(), (p - b).squaredNorm(), (p - c).squaredNorm()};
    std::array<double, 3> out{};
    out[static_cast<size_t>(std::min_element(away.begin(), away.end()) - away.begin())] = 1;
    return out;
  }
  const double v = (d11 * d20 - d01 * d21) / area, w = (d00 * d21 - d01 * d20) / area;
  return {1 - v - w, v, w};
}

Vector3d face_normal(const Skin& skin, const PosedSkin& posed, int face) {
  const auto& f = skin.faces[static_cast<size_t>(face)];
  const Vector3d& a = posed.vertices[static_cast<size_t>(f[0])];
  return (posed.vertices[static_cast<size_t>(f[1])] - a).cross(posed.vertices[static_cast<size_t>(f[2])] - a);
}

/// Derivatives of places on the skin in one frame by the main system's unknowns.
class SkinJacobian {
 public:
  SkinJacobian(const Problem& problem, const Unknowns& unknowns, const Skin& skin, const FramePose& pose,
               const BonesPose& bones, const PosedSkin& posed)
      : problem_(problem), unknowns_(unknowns), skin_(skin), bones_(bones), posed_(posed) {
    for (const Eigen::Quaterniond& q : bones.rotations) rotations_.push_back(q.toRotationMatrix());
    for (const Eigen::Quaterniond& q : pose.local) local_.push_back(q.toRotationMatrix());
  }

  /// Adds scale times d (direction . place) to `row`, the place being the sum of `count` vertices by weights.
  void add(const int* vertices, const double* weights, int count, const Vector3d& direction, double scale,
           double* row) {
    moments_.assign(rotations_.size(), Vector3d::Zero());
    masses_.assign(rotations_.size(), 0);
    const bool blends = skin_.pose_dirs.size() > 0;
    if (blends) pulled_.setZero(9 * kPosed);
    for (int i = 0; i < count; ++i) {
      if (weights[i] == 0) continue;
      const auto v = static_cast<size_t>(vertices[i]);
      Vector3d at_rest = Vector3d::Zero();
      for (int k = skin_.first[v]; k < skin_.first[v + 1]; ++k) {
        const auto [joint, own] = skin_.weights[static_cast<size_t>(k)];
        const auto j = static_cast<size_t>(joint);
        const double weight = scale * weights[i] * own;
        const Vector3d at = bones_.positions[j] + rotations_[j] * (posed_.rest[v] - skin_.joints[j]);
        moments_[j] += weight * at.cross(direction);
        masses_[j] += weight;
        if (blends) at_rest += weight * (rotations_[j].transpose() * direction);
      }
      if (blends)
        pulled_ += skin_.pose_dirs.middleRows<3>(3 * static_cast<Eigen::Index>(v)).transpose().cast<double>() * at_rest;
    }
    // What a joint carries is what hangs on it and on the joints below: parents come first.
    double whole = 0;
    for (size_t j = rotations_.size(); j-- > 0;) {
      const auto [system, column] = unknowns_.rotations[j];
      if (system == Unknowns::kMain) {
        const Vector3d torque = moments_[j] - masses_[j] * bones_.positions[j].cross(direction);
        Eigen::Map<Vector3d>(row + column) += rotations_[j].transpose() * torque;
        if (blends && j > 0 && j <= kPosed) {
          const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> shape(pulled_.data() + 9 * (j - 1));
          const Matrix3d g = local_[j].transpose() * shape;
          Eigen::Map<Vector3d>(row + column) += Vector3d(g(2, 1) - g(1, 2), g(0, 2) - g(2, 0), g(1, 0) - g(0, 1));
        }
      }
      const int parent = problem_.bones.parents[j];
      if (parent < 0) {
        whole += masses_[j];
        continue;
      }
      moments_[static_cast<size_t>(parent)] += moments_[j];
      masses_[static_cast<size_t>(parent)] += masses_[j];
    }
    if (unknowns_.root >= 0) Eigen::Map<Vector3d>(row + unknowns_.root) += whole * direction;
  }

 private:
  const Problem& problem_;
  const Unknowns& unknowns_;
  const Skin& skin_;
  const BonesPose& bones_;
  const PosedSkin& posed_;
  std::vector<Matrix3d> rotations_, local_;
  std::vector<Vector3d> moments_;
  std::vector<double> masses_;
  VectorXd pulled_;
};

}  // namespace

Skin skin_of(const BodyModel& model, const torch::Tensor& betas) {
  const torch::NoGradGuard no_gradients;
  Skin out;
  torch::Tensor rest = model.template_vertices, joints = model.joint_template;
  if (betas.defined() && betas.numel() > 0) {
    const int64_t count = std::min(betas.size(0), model.betas());  // later ones change little
    const torch::Tensor b = betas.narrow(0, 0, count).to(torch::kFloat32);
    rest = rest + model.shape_dirs.narrow(2, 0, count).matmul(b);
    joints = joints + model.joint_dirs.narrow(2, 0, count).matmul(b);
  }
  out.rest = rows_of(rest);
  out.joints = rows_of(joints.slice(0, 0, kStandardJoints));
  std::vector<int> standard;  // the standard joint that carries each of the model's
  standard.reserve(static_cast<size_t>(model.joints()));
  for (int j = 0; j < model.joints(); ++j)
    standard.push_back(j < kStandardJoints ? j : standard[static_cast<size_t>(model.skeleton.parents[j])]);

  const torch::Tensor weights = model.skin_weights.to(torch::kCPU, torch::kFloat64).contiguous();
  const auto w = weights.accessor<double, 2>();
  out.first.push_back(0);
  for (int64_t v = 0; v < out.size(); ++v) {
    std::array<double, kStandardJoints> own{};
    for (int64_t j = 0; j < model.joints(); ++j) own[static_cast<size_t>(standard[static_cast<size_t>(j)])] += w[v][j];
    for (int j = 0; j < kStandardJoints; ++j)
      if (own[static_cast<size_t>(j)] != 0) out.weights.push_back({j, own[static_cast<size_t>(j)]});
    out.first.push_back(static_cast<int>(out.weights.size()));
  }

  const torch::Tensor faces = model.faces.to(torch::kCPU, torch::kInt64).contiguous();
  const auto f = faces.accessor<int64_t, 2>();
  std::vector<int> count(out.rest.size() + 1, 0);
  for (int64_t i = 0; i < faces.size(0); ++i) {
    out.faces.push_back({static_cast<int>(f[i][0]), static_cast<int>(f[i][1]), static_cast<int>(f[i][2])});
    for (const int v : out.faces.back()) ++count[static_cast<size_t>(v) + 1];
  }
  for (size_t v = 1; v < count.size(); ++v) count[v] += count[v - 1];
  out.first_face = count;
  out.vertex_faces.resize(3 * out.faces.size());
  for (size_t i = 0; i < out.faces.size(); ++i)
    for (const int v : out.faces[i])
      out.vertex_faces[static_cast<size_t>(count[static_cast<size_t>(v)]++)] = static_cast<int>(i);

  if (model.pose_dirs.defined()) {
    const torch::Tensor dirs =
        model.pose_dirs.slice(2, 0, 9 * kPosed).to(torch::kCPU, torch::kFloat32).flatten(0, 1).contiguous();
    out.pose_dirs = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        dirs.data_ptr<float>(), dirs.size(0), dirs.size(1));
  }
  return out;
}

torch::Tensor shape_in(const Clip& clip, const BodyModel& body) {
  const torch::Tensor& betas = clip.betas;
  if (!betas.defined() || betas.dim() != 1 || betas.size(0) > body.betas()) return {};
  if (&body == &builtin_body()) return betas;
  const torch::Tensor apart =
      (shaped_skeleton(body, betas).offsets.slice(0, 1, kStandardJoints) - clip.skeleton.offsets.slice(0, 1)).abs();
  return apart.max().item<double>() < 0.01 ? betas : torch::Tensor();
}

PosedSkin pose_skin(const Skin& skin, const FramePose& pose, const BonesPose& bones) {
  PosedSkin out{skin.rest, std::vector<Vector3d>(skin.rest.size())};
  if (skin.pose_dirs.size() > 0) {
    Eigen::VectorXf feature(9 * kPosed);
    for (int j = 1; j <= kPosed; ++j) {
      const Matrix3d r = pose.local[static_cast<size_t>(j)].toRotationMatrix() - Matrix3d::Identity();
      for (int i = 0; i < 9; ++i) feature[9 * (j - 1) + i] = static_cast<float>(r(i / 3, i % 3));
    }
    const Eigen::VectorXf moved = skin.pose_dirs * feature;
    for (size_t v = 0; v < out.rest.size(); ++v)
      out.rest[v] += moved.segment<3>(3 * static_cast<Eigen::Index>(v)).cast<double>();
  }
  std::vector<Matrix3d> rotations(skin.joints.size());
  std::vector<Vector3d> shifts(skin.joints.size());
  for (size_t j = 0; j < skin.joints.size(); ++j) {
    rotations[j] = bones.rotations[j].toRotationMatrix();
    shifts[j] = bones.positions[j] - rotations[j] * skin.joints[j];
  }
  for (size_t v = 0; v < out.rest.size(); ++v) {
    Vector3d at = Vector3d::Zero();
    for (int k = skin.first[v]; k < skin.first[v + 1]; ++k) {
      const auto [joint, weight] = skin.weights[static_cast<size_t>(k)];
      at += weight * (rotations[static_cast<size_t>(joint)] * out.rest[v] + shifts[static_cast<size_t>(joint)]);
    }
    out.vertices[v] = at;
  }
  return out;
}

std::vector<SkinPlace> closest_on_skin(const Skin& skin, const PosedSkin& posed, const std::vector<Vector3d>& points) {
  std::vector<SkinPlace> out(points.size());
  if (points.empty()) return out;
  const int64_t count = std::min<int64_t>(3, skin.size());
  const torch::Tensor near = CloudQuery(point_rows(posed.vertices)).nearest(point_rows(points), count).indices;
  const auto index = near.accessor<int64_t, 2>();
  for (size_t i = 0; i < points.size(); ++i) {
    double least = HUGE_VAL;
    for (int64_t n = 0; n < count; ++n) {
      const auto v = static_cast<size_t>(index[static_cast<int64_t>(i)][n]);
      for (int k = skin.first_face[v]; k < skin.first_face[v + 1]; ++k) {
        const int face = skin.vertex_faces[static_cast<size_t>(k)];
        const auto& f = skin.faces[static_cast<size_t>(face)];
        const Vector3d at = closest_on_triangle<double>(points[i], posed.vertices[static_cast<size_t>(f[0])],
                                                        posed.vertices[static_cast<size_t>(f[1])],
                                                        posed.vertices[static_cast<size_t>(f[2])]);
        const double away = (at - points[i]).squaredNorm();
        if (away >= least) continue;
        least = away;
        out[i].face = face;
        out[i].place = at;
      }
    }
    if (out[i].face < 0) continue;  // vertices without a face
    const auto& f = skin.faces[static_cast<size_t>(out[i].face)];
    out[i].corners = barycentric(out[i].place, posed.vertices[static_cast<size_t>(f[0])],
                                 posed.vertices[static_cast<size_t>(f[1])], posed.vertices[static_cast<size_t>(f[2])]);
  }
  return out;
}

std::vector<int> seen_vertices(const Skin& skin, const PosedSkin& posed, const Vector3d& camera, int step) {
  constexpr float kSelf = 0.01F;  // metres before the vertex: its own skin
  Scene scene;
  torch::Tensor faces = torch::empty({static_cast<int64_t>(skin.faces.size()), 3}, torch::kInt64);
  int64_t* corner = faces.data_ptr<int64_t>();
  for (const auto& face : skin.faces) corner = std::copy(face.begin(), face.end(), corner);
  scene.meshes.push_back({"skin", point_rows(posed.vertices), faces, {}});
  std::vector<int> tried, out;
  std::vector<Vector3d> rays;
  for (int v = 0; v < skin.size(); v += step) {
    tried.push_back(v);
    rays.emplace_back(posed.vertices[static_cast<size_t>(v)] - camera);
  }
  const std::vector<Vector3d> from(rays.size(), camera);
  const torch::Tensor hits = SceneQuery(scene).cast(point_rows(from), point_rows(rays)).points;
  const auto hit = hits.accessor<float, 2>();
  for (size_t i = 0; i < tried.size(); ++i) {
    const auto k = static_cast<int64_t>(i);
    const Vector3d before = posed.vertices[static_cast<size_t>(tried[i])] - Vector3d(hit[k][0], hit[k][1], hit[k][2]);
    if (before.norm() < kSelf) out.push_back(tried[i]);
  }
  return out;
}

void add_depth_rows(const Problem& problem, const Unknowns* unknowns, int64_t frame, const FramePose& pose,
                    const BonesPose& bones, std::vector<double>& values, std::vector<double>& residuals, double& cost) {
  const DepthTerm& term = *problem.depth;
  const DepthCloud& cloud = term.clouds[static_cast<size_t>(frame)];
  if (cloud.points.empty()) return;
  const Skin& skin = *term.skin;
  const PosedSkin posed = pose_skin(skin, pose, bones);
  std::optional<SkinJacobian> jacobian;
  const int columns = unknowns != nullptr ? unknowns->columns[Unknowns::kMain] : 0;
  if (unknowns != nullptr) jacobian.emplace(problem, *unknowns, skin, pose, bones, posed);
  const auto add_row = [&](const int* vertices, const double* weights, int count, const Vector3d& direction, double r,
                           double weight) {
    const double root = std::sqrt(weight);
    values.resize(values.size() + static_cast<size_t>(columns), 0);
    jacobian->add(vertices, weights, count, direction, root, &*values.end() - columns);
    residuals.push_back(root * r);
  };
  // Beyond reach a residual costs the same wherever it is.
  const auto loss = [&](double squared) {
    const double limit = term.reach * term.reach;
    return squared < limit ? weighted(term.loss, squared) : Weighted{weighted(term.loss, limit).cost, 0};
  };

  const std::vector<SkinPlace> places = closest_on_skin(skin, posed, cloud.points);
  const double each = term.weight / static_cast<double>(places.size());
  for (size_t i = 0; i < places.size(); ++i) {
    const SkinPlace& place = places[i];
    if (place.face < 0) continue;
    const Vector3d apart = place.place - cloud.points[i];
    const double away = apart.norm();
    const Weighted w = loss(away * away);
    cost += each * w.cost;
    if (unknowns == nullptr || w.factor == 0) continue;
    // On the surface the distance has no direction but the normal's.
    const Vector3d direction = away > 1e-9 ? Vector3d(apart / away) : face_normal(skin, posed, place.face).normalized();
    add_row(skin.faces[static_cast<size_t>(place.face)].data(), place.corners.data(), 3, direction, away,
            each * w.factor);
  }

  if (cloud.seen.empty()) return;
  const std::vector<int>& seen = cloud.seen;
  std::vector<Vector3d> at;
  at.reserve(at.size() + seen.size());
  for (const int v : seen) at.push_back(posed.vertices[static_cast<size_t>(v)]);
  const torch::Tensor near = cloud.all_points->nearest(point_rows(at)).indices;
  const auto index = near.accessor<int64_t, 2>();
  const double each_vertex = term.weight / static_cast<double>(seen.size()), whole = 1;
  for (size_t i = 0; i < seen.size(); ++i) {
    const Vector3d apart = at[i] - cloud.all[static_cast<size_t>(index[static_cast<int64_t>(i)][0])];
    const Weighted w = loss(apart.squaredNorm());
    cost += each_vertex * w.cost;
    if (unknowns == nullptr || w.factor == 0) continue;
    for (int k = 0; k < 3; ++k) add_row(&seen[i], &whole, 1, Vector3d::Unit(k), apart[k], each_vertex * w.factor);
  }
}

std::vector<double> distances_to_skin(const Skin& skin, const FramePose& pose, const Bones& bones,
                                      const std::vector<Vector3d>& points) {
  BonesPose posed;
  pose_bones(bones, pose.local, pose.trans, posed);
  const std::vector<SkinPlace> places = closest_on_skin(skin, pose_skin(skin, pose, posed), points);
  std::vector<double> out;
  for (size_t i = 0; i < points.size(); ++i)
    out.push_back(places[i].face < 0 ? HUGE_VAL : (places[i].place - points[i]).norm());
  return out;
}

}  // namespace inhabit::refine
