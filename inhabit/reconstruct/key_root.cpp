#include "inhabit/reconstruct/key_root.h"

#include <algorithm>
#include <cmath>

#include "inhabit/refine/scene_terms.h"
#include "inhabit/refine/solve.h"
#include "inhabit/refine/weights.h"
#include "inhabit/scene/point_rows.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;
using refine::weight_of;

constexpr double kTouch = 0.06, kStill = 0.3;   // metres; m/s
constexpr double kFacing = 0.3, kUpward = 0.5;  // cosines: the skin looks down at it, the surface up
constexpr double kInside = 0.3;                 // metres under a surface that a vertex may be found at
constexpr double kFar = 1, kNear = 0.3;         // metres: reach of the depth term, first and then
constexpr double kSurround = 0.05;              // metres from the scene within which it is minded
constexpr int kTouchStep = 3;                   // every so many vertices may touch
constexpr int kContactRounds = 2;

/// Directions in which the skin looks, not of unit length.
std::vector<Vector3d> skin_normals(const refine::Skin& skin, const refine::PosedSkin& posed) {
  std::vector<Vector3d> out(posed.vertices.size(), Vector3d::Zero());
  for (const auto& face : skin.faces) {
    const Vector3d& a = posed.vertices[static_cast<size_t>(face[0])];
    const Vector3d n =
        (posed.vertices[static_cast<size_t>(face[1])] - a).cross(posed.vertices[static_cast<size_t>(face[2])] - a);
    for (const int v : face) out[static_cast<size_t>(v)] += n;
  }
  return out;
}

class KeyRootSearch {
 public:
  KeyRootSearch(const BodyInFrames& body, const torch::Tensor& betas, double rate, const std::vector<int64_t>& keys,
                const Scene& scene, const KeyRootOptions& options)
      : body_(body),
        options_(options),
        surroundings_(scene),
        surfaces_(meshes_of(scene)),
        balls_(refine::body_balls(builtin_body(), betas)) {
    problem_.bones = body.bones;
    const auto steps = static_cast<double>(keys.size()) - 1;
    problem_.rate = steps > 0 ? rate * steps / static_cast<double>(keys.back() - keys.front()) : rate;
    for (const int64_t key : keys) problem_.start.push_back(body.poses[static_cast<size_t>(key)]);
    problem_.rotates.assign(static_cast<size_t>(body.bones.size()), 0);
    problem_.stay_near.rotations.assign(keys.size() * static_cast<size_t>(body.bones.size()), 0);
    problem_.stay_near.root.assign(keys.size(), weight_of(options.near));
    if (keys.size() > 2) {
      std::vector<double> root(static_cast<size_t>(body.bones.size()), 0);
      root[0] = 1;
      problem_.smoothness.push_back({2, weight_of(options.change), 0, {}, false, root});
    }
  }

  KeyRoots run(const std::vector<refine::DepthCloud>& clouds) {
    reset_points();
    refine::Trajectory found = solved(problem_.start, clouds, kFar);
    found = solved(found, clouds, kNear);
    KeyRoots out;
    for (int round = 0; round < kContactRounds; ++round) {
      reset_points();
      out.contacts = add_contacts(found);
      const std::vector<refine::PlaneTerm> inside =
          surroundings_.planes(balls_, problem_.bones.size(), refine::posed(problem_.bones, found), 0, kSurround,
                               weight_of(options_.contact));
      problem_.planes.insert(problem_.planes.end(), inside.begin(), inside.end());
      found = solved(found, clouds, kNear);
    }
    for (size_t k = 0; k < found.size(); ++k) out.moved.emplace_back(found[k].trans - problem_.start[k].trans);
    return out;
  }

 private:
  static Scene meshes_of(const Scene& scene) {
    Scene out = scene;
    out.points = torch::Tensor();
    return out;
  }

  void reset_points() {
    problem_.planes.clear();
    problem_.points = refine::joint_points(problem_.bones.size());
    for (const refine::BodyBall& ball : balls_) problem_.points.push_back(ball.point);
  }

  refine::Trajectory solved(const refine::Trajectory& from, const std::vector<refine::DepthCloud>& clouds,
                            double reach) {
    auto depth = std::make_shared<refine::DepthTerm>();
    depth->skin = body_.skin;
    depth->clouds = clouds;
    depth->weight = 2 * weight_of(options_.depth);
    depth->loss = {refine::Loss::Kind::huber, 0.05};
    depth->reach = reach;
    problem_.depth = depth;
    problem_.initial = from;
    return refine::solve(problem_, {12, 1e-4}).trajectory;
  }

  std::vector<refine::PosedSkin> posed_skins(const refine::Trajectory& poses) const {
    std::vector<refine::PosedSkin> out;
    out.reserve(poses.size());
    BonesPose bones;
    for (const refine::FramePose& pose : poses) {
      pose_bones(body_.bones, pose.local, pose.trans, bones);
      out.push_back(refine::pose_skin(*body_.skin, pose, bones));
    }
    return out;
  }

  /// A vertex of the skin as a point of the problem.
  int point_at(const refine::PosedSkin& posed, size_t v) {
    refine::Point point;
    for (int i = body_.skin->first[v]; i < body_.skin->first[v + 1]; ++i) {
      const auto& [joint, weight] = body_.skin->weights[static_cast<size_t>(i)];
      point.push_back({joint, weight, posed.rest[v] - body_.skin->joints[static_cast<size_t>(joint)]});
    }
    problem_.points.push_back(std::move(point));
    return static_cast<int>(problem_.points.size()) - 1;
  }

  /// Planes on which vertices in contact are kept, and out of which others are kept. @return how many are in contact
  int64_t add_contacts(const refine::Trajectory& found) {
    const std::vector<refine::PosedSkin> skins = posed_skins(found);
    int64_t all = 0;
    for (size_t k = 0; k < skins.size(); ++k) {
      const std::vector<Vector3d> normals = skin_normals(*body_.skin, skins[k]);
      std::vector<size_t> looked;
      std::vector<Vector3d> places;
      for (size_t v = 0; v < normals.size(); v += kTouchStep) {
        if (normals[v].y() > -kFacing * normals[v].norm()) continue;
        looked.push_back(v);
        places.push_back(skins[k].vertices[v]);
      }
      if (looked.empty()) continue;
      const ClosestPoints closest = surfaces_.closest(point_rows(places));
      const auto at = closest.points.accessor<float, 2>(), normal = closest.normals.accessor<float, 2>();
      std::vector<refine::PlaneTerm> touching;
      for (size_t i = 0; i < looked.size(); ++i) {
        const auto row = static_cast<int64_t>(i);
        const Vector3d n(normal[row][0], normal[row][1], normal[row][2]), on(at[row][0], at[row][1], at[row][2]);
        const double above = n.dot(places[i] - on);
        if (n.y() < kUpward || std::abs(above) > kInside) continue;
        const bool touches = std::abs(above) < kTouch && still(skins, k, looked[i]);
        if (!touches && above > 0) continue;
        refine::PlaneTerm term{static_cast<int64_t>(k), point_at(skins[k], looked[i]), n, n.dot(on), 0, touches};
        touching.push_back(term);
        all += touches ? 1 : 0;
      }
      for (refine::PlaneTerm& term : touching) {
        term.weight = weight_of(options_.contact) / static_cast<double>(touching.size());
        problem_.planes.push_back(term);
      }
    }
    return all;
  }

  /// Whether a vertex moves slowly from the key before or to the one after.
  bool still(const std::vector<refine::PosedSkin>& skins, size_t k, size_t v) const {
    double least = HUGE_VAL;
    const Vector3d& here = skins[k].vertices[v];
    if (k > 0) least = (here - skins[k - 1].vertices[v]).norm();
    if (k + 1 < skins.size()) least = std::min(least, (here - skins[k + 1].vertices[v]).norm());
    return least * problem_.rate < kStill;
  }

  const BodyInFrames& body_;
  const KeyRootOptions& options_;
  refine::Surroundings surroundings_;
  SceneQuery surfaces_;
  std::vector<refine::BodyBall> balls_;
  refine::Problem problem_;
};

}  // namespace

KeyRoots optimise_key_roots(const BodyInFrames& body, const torch::Tensor& betas, double rate,
                            const std::vector<int64_t>& keys, const std::vector<refine::DepthCloud>& clouds,
                            const Scene& scene, const KeyRootOptions& options) {
  return KeyRootSearch(body, betas, rate, keys, scene, options).run(clouds);
}

}  // namespace inhabit::reconstruct
