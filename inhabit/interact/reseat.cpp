#include "inhabit/interact/reseat.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "inhabit/body/body_model.h"
#include "inhabit/body/joint_limits.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/interact/seated.h"
#include "inhabit/math/rotation.h"
#include "inhabit/refine/scene_terms.h"
#include "inhabit/refine/solve.h"
#include "inhabit/refine/weights.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/query.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;
using refine::weight_of;

constexpr double kFarthestPlace = 0.12;                       // metres from where a hand's place should be to a surface
constexpr double kHandExact = 0.001, kFootExact = 0.001;      // metres
constexpr double kPelvisHeight = 0.002, kPelvisPlace = 0.03;  // metres
constexpr int64_t kChangedAround = 20;                        // frames before and after that change too
constexpr std::array<int, 4> kFootJoints = {7, 8, 10, 11};

torch::Tensor row_of(const Vector3d& p) { return torch::tensor({p.x(), p.y(), p.z()}, torch::kFloat).view({1, 3}); }
Vector3d vector_of(const torch::Tensor& row) {
  const torch::Tensor d = row.to(torch::kDouble).contiguous();
  return Eigen::Map<const Vector3d>(d.data_ptr<double>());
}

Mesh moved(const Mesh& mesh, const Eigen::Isometry3d& motion) {
  torch::Tensor turn = torch::empty({3, 3}), shift = torch::empty({3});
  for (int r = 0; r < 3; ++r) {
    shift[r] = motion.translation()[r];
    for (int c = 0; c < 3; ++c) turn[r][c] = motion.linear()(r, c);
  }
  Mesh out = mesh;
  out.vertices = torch::matmul(mesh.vertices, turn.t()) + shift;
  return out;
}

/// A hand at one place in frames [first, last].
struct Hold {
  int side = 0;
  int64_t first = 0, last = 0;
  Vector3d point = Vector3d::Zero();
  bool kept = false;
  Vector3d to = Vector3d::Zero();                            ///< the place on the new chair
  Eigen::Quaterniond tilt = Eigen::Quaterniond::Identity();  ///< of the new surface against the old one
};

std::vector<Hold> holds_of(const Clip& clip) {
  std::vector<Hold> holds;
  if (!clip.hand_targets.defined()) return holds;
  const torch::Tensor targets = clip.hand_targets.to(torch::kDouble).contiguous();
  const auto h = targets.accessor<double, 3>();
  for (int side = 0; side < 2; ++side)
    for (int64_t t = 0; t < clip.frames(); ++t) {
      if (h[t][side][3] < 0.5) continue;
      const Vector3d point(h[t][side][0], h[t][side][1], h[t][side][2]);
      const bool goes_on = !holds.empty() && holds.back().side == side && holds.back().last == t - 1 &&
                           (holds.back().point - point).norm() < 0.005;
      if (goes_on)
        holds.back().last = t;
      else
        holds.push_back({side, t, t, point});
    }
  return holds;
}

/// Both chairs, the new one where it is to stand.
struct Chairs {
  Chair old, fresh;
  SeatExtent old_seat, fresh_seat;
  Scene fresh_scene;  ///< the new chair alone
  std::unique_ptr<SceneQuery> old_surface, fresh_surface;

  double rise() const { return fresh.seat_height - old.seat_height; }
};

Chairs both_chairs(const Clip& clip, const Scene& scene, const Scene& chairs, const std::string& name) {
  const auto old = chair_of(clip, scene);
  if (!old) throw Error("clip", "nobody sits in it");
  Chairs out{*old, find_chair(chairs, name), {}, {}, {}, nullptr, nullptr};
  out.old_seat = seat_extent(out.old);
  out.fresh_seat = seat_extent(out.fresh);
  // Front edge to front edge, so that shanks and feet are as far from it as before.
  const Eigen::Isometry3d place =
      out.old.frame * Eigen::Translation3d(0, 0, out.old_seat.front - out.fresh_seat.front) * out.fresh.frame.inverse();
  for (const Mesh& mesh : chairs.meshes) {
    if (object_of_mesh(mesh.name) != name) continue;
    Mesh copy = moved(mesh, place);
    copy.name = out.old.name + mesh.name.substr(name.size());
    out.fresh_scene.meshes.push_back(copy);
  }
  out.fresh.name = out.old.name;
  out.fresh.mesh = moved(out.fresh.mesh, place);
  out.fresh.frame = place * out.fresh.frame;
  Scene alone;
  alone.meshes = {out.old.mesh};
  out.old_surface = std::make_unique<SceneQuery>(alone);
  out.fresh_surface = std::make_unique<SceneQuery>(out.fresh_scene);
  return out;
}

/// Where a hold goes on the new chair, if there is such a place.
void carry(const Chairs& chairs, const Vector3d& wrist, Hold& hold) {
  const Vector3d own = chairs.old.frame.inverse() * hold.point;
  const Vector3d there = chairs.fresh.frame * corresponding(own, chairs.old_seat, chairs.old.seat_height,
                                                            chairs.fresh_seat, chairs.fresh.seat_height);
  const ClosestPoints before = chairs.old_surface->closest(row_of(hold.point));
  const ClosestPoints after = chairs.fresh_surface->closest(row_of(there));
  if (before.distances[0].item<double>() > 0.03 || after.distances[0].item<double>() > kFarthestPlace) return;
  Vector3d from = vector_of(before.normals[0]), to = vector_of(after.normals[0]);
  const Vector3d away = wrist - hold.point;
  if (from.dot(away) < 0) from = -from;
  if (to.dot(from) < 0) to = -to;
  if (to.dot(from) < 0.7) return;  // the top of an arm rest is no side of one
  hold.to = vector_of(after.points[0]);
  hold.tilt = Eigen::Quaterniond::FromTwoVectors(from, to);
  hold.kept = true;
}

class Reseating {
 public:
  Reseating(const Clip& clip, const Scene& scene, const Scene& chairs, const std::string& name)
      : clip_(clip), chairs_(both_chairs(clip, scene, chairs, name)), balls_(refine::body_balls(body_, clip.betas)) {
    out_.scene = obstacles_of(scene, chairs_.old.name);
    for (const Mesh& mesh : scene.meshes)
      if (is_floor(mesh.name)) out_.scene.meshes.push_back(mesh);
    for (const Mesh& mesh : chairs_.fresh_scene.meshes) out_.scene.meshes.push_back(mesh);
    out_.scene.name = scene.name;
    start_ = refine::trajectory_of(clip);
    poses_ = refine::posed(bones_of(clip.skeleton), start_);
  }

  Reseated run(bool lose_contacts) {
    find_stays();
    for (Hold& hold : holds_) {
      const auto wrist = static_cast<size_t>(20 + hold.side);
      carry(chairs_, poses_[static_cast<size_t>((hold.first + hold.last) / 2)].positions[wrist], hold);
      ++(hold.kept ? out_.contacts : out_.lost);
    }
    if (out_.lost > 0 && !lose_contacts) throw Error(chairs_.fresh.name, "has no place for what a hand touches");
    build();
    const refine::Surroundings surroundings(out_.scene);
    for (int round = 0; round < 3; ++round) {
      if (round > 0)
        problem_.planes = surroundings.planes(balls_, kStandardJoints, refine::posed(problem_.bones, problem_.initial),
                                              0.05, weight_of(0.003));
      problem_.initial = refine::solve(problem_, {8, 1e-3}).trajectory;
    }
    put_together();
    measure();
    return std::move(out_);
  }

 private:
  void find_stays() {
    first_ = clip_.frames(), last_ = -1;
    for (const Stay& stay : stays_of(clip_)) {
      const Vector3d away = chairs_.old.frame.inverse() * stay.rest;
      if (std::hypot(away.x(), away.z()) > 1) continue;  // on something else
      stays_.push_back(stay);
      first_ = std::min(first_, stay.down);
      last_ = std::max(last_, stay.rises ? stay.risen : clip_.frames() - 1);
    }
    holds_ = holds_of(clip_);
    std::erase_if(holds_, [&](const Hold& hold) {  // of other furniture
      return chairs_.old_surface->closest(row_of(hold.point)).distances[0].item<double>() > 0.05;
    });
    for (const Hold& hold : holds_) {
      first_ = std::min(first_, hold.first);
      last_ = std::max(last_, hold.last);
    }
    first_ = std::max<int64_t>(0, first_ - kChangedAround);
    last_ = std::min(clip_.frames() - 1, last_ + kChangedAround);
  }

  void build() {
    const auto frames = static_cast<size_t>(last_ - first_ + 1);
    problem_.bones = bones_of(clip_.skeleton);
    problem_.rate = clip_.rate;
    problem_.start.assign(start_.begin() + first_, start_.begin() + last_ + 1);
    problem_.initial = problem_.start;
    problem_.points = refine::joint_points(kStandardJoints);
    for (const refine::BodyBall& ball : balls_) problem_.points.push_back(ball.point);
    const double per_frame = 30 / clip_.rate;
    problem_.stay_near.rotations.assign(frames * kStandardJoints, per_frame * weight_of(0.2));
    problem_.stay_near.root.assign(frames, per_frame * weight_of(0.6));
    std::vector<double> root_alone(kStandardJoints, 0);
    root_alone[0] = 1;
    problem_.smoothness.push_back({2, per_frame * weight_of(2), 0, {}, true, root_alone});
    problem_.smoothness.push_back({2, 0, per_frame * weight_of(2), {}, true, {}});
    problem_.fixed.assign(frames, 0);
    for (size_t t = 0; t < 3 && frames > 8; ++t) {
      if (first_ > 0) problem_.fixed[t] = 1;
      if (last_ + 1 < clip_.frames()) problem_.fixed[frames - 1 - t] = 1;
    }
    const JointLimits limits = joint_limits(body_);
    problem_.low.assign(limits.low.begin(), limits.low.begin() + kStandardJoints);
    problem_.high.assign(limits.high.begin(), limits.high.begin() + kStandardJoints);
    problem_.limit_weight = weight_of(0.003);
    add_pelvis();
    add_feet();
    for (const Hold& hold : holds_)
      if (hold.kept) add_hold(hold);
  }

  void add_place(int64_t frame, int point, const Vector3d& target, const Vector3d& sigma) {
    problem_.places.push_back({frame - first_, point, target, sigma.cwiseProduct(sigma).cwiseInverse(), {}});
  }

  /// On the seat, as far over it as before; not off its rear edge nor in the back rest.
  Vector3d pelvis_target(int64_t frame) const {
    const Vector3d before = poses_[static_cast<size_t>(frame)].positions[0];
    Vector3d own = chairs_.fresh.frame.inverse() * before;
    own.z() = std::max(own.z(), std::min(chairs_.fresh_seat.rear + 0.13, chairs_.fresh_seat.front - 0.12));
    Vector3d target = chairs_.fresh.frame * own;
    target.y() = before.y() + chairs_.rise();
    return target;
  }

  void add_pelvis() {
    for (const Stay& stay : stays_)
      for (int64_t t = stay.first; t <= stay.last; ++t)
        add_place(t, 0, pelvis_target(t), {kPelvisPlace, kPelvisHeight, kPelvisPlace});
  }

  bool foot_down(int64_t t, int joint) const { return clip_.contact[t][joint].item<float>() > 0.5F; }

  void add_feet() {
    for (int64_t t = first_; t <= last_; ++t)
      for (const int joint : kFootJoints)
        add_place(t, joint, poses_[static_cast<size_t>(t)].positions[static_cast<size_t>(joint)],
                  Vector3d::Constant(foot_down(t, joint) ? kFootExact : 0.01));
  }

  /// Wrist and touched point of the palm, moved together.
  void add_hold(const Hold& hold) {
    const auto wrist = static_cast<size_t>(20 + hold.side);
    for (int64_t t = hold.first; t <= hold.last; ++t) {
      const BonesPose& before = poses_[static_cast<size_t>(t)];
      const Vector3d away = before.positions[wrist] - hold.point;
      problem_.points.push_back({{static_cast<int>(wrist), 1, before.rotations[wrist].conjugate() * -away}});
      add_place(t, static_cast<int>(wrist), hold.to + hold.tilt * away, Vector3d::Constant(kHandExact));
      add_place(t, static_cast<int>(problem_.points.size()) - 1, hold.to, Vector3d::Constant(kHandExact));
    }
  }

  void put_together() {
    refine::Trajectory whole = start_;
    std::copy(problem_.initial.begin(), problem_.initial.end(), whole.begin() + first_);
    out_.clip = refine::clip_of(whole, clip_);
    out_.clip.contact = clip_.contact.clone();
    if (clip_.hand_targets.defined()) out_.clip.hand_targets = clip_.hand_targets.clone();
    for (const Hold& hold : holds_) {
      torch::Tensor rows = out_.clip.hand_targets.slice(0, hold.first, hold.last + 1).select(1, hold.side);
      rows.zero_();
      if (hold.kept)
        rows.copy_(torch::cat({row_of(hold.to), torch::ones({1, 1})}, 1).expand_as(rows));
      else
        out_.clip.contact.slice(0, hold.first, hold.last + 1).select(1, 20 + hold.side).zero_();
    }
    for (size_t o = 0; o < clip_.object_names.size(); ++o) {
      if (clip_.object_names[o] != chairs_.fresh.name) continue;
      out_.clip.object_pose = out_.clip.object_pose.clone();
      const torch::Tensor low = std::get<0>(chairs_.fresh.mesh.vertices.min(0)),
                          high = std::get<0>(chairs_.fresh.mesh.vertices.max(0));
      torch::Tensor pose = torch::zeros({6});
      pose[0] = (low[0] + high[0]) / 2;
      pose[1] = low[1];
      pose[2] = (low[2] + high[2]) / 2;
      pose[4] = chairs_.fresh.heading();
      out_.clip.object_pose.select(1, static_cast<int64_t>(o)).copy_(pose.expand({clip_.frames(), 6}));
    }
  }

  /// Deepest vertex of the skin in a surface over every sixth frame of the stays, metres.
  double depth_in(const Clip& clip, const SceneQuery& surface) const {
    double deepest = 0;
    for (const Stay& stay : stays_) {
      std::vector<int64_t> frames;
      for (int64_t t = stay.first; t <= stay.last; t += 6) frames.push_back(t);
      const torch::Tensor index = torch::tensor(frames);
      const torch::Tensor places = skin(body_, clip.betas, axis_angle_to_matrix(clip.rotations.index_select(0, index)),
                                        clip.trans.index_select(0, index));
      deepest = std::max(deepest, -surface.signed_distance(places.reshape({-1, 3}).contiguous()).min().item<double>());
    }
    return deepest;
  }

  void measure() {
    const refine::Poses found = refine::posed(problem_.bones, problem_.initial);
    for (const Hold& hold : holds_) {
      if (!hold.kept) continue;
      const auto wrist = static_cast<size_t>(20 + hold.side);
      for (int64_t t = hold.first; t <= hold.last; ++t) {
        const BonesPose& before = poses_[static_cast<size_t>(t)];
        const BonesPose& after = found[static_cast<size_t>(t - first_)];
        const Vector3d palm = before.rotations[wrist].conjugate() * (hold.point - before.positions[wrist]);
        const Vector3d there = after.positions[wrist] + after.rotations[wrist] * palm;
        out_.hand_gap = std::max(out_.hand_gap, (there - hold.to).norm());
      }
    }
    std::vector<double> heights{0};
    for (const Stay& stay : stays_)
      for (int64_t t = stay.first; t <= stay.last; ++t)
        heights.push_back(std::abs(found[static_cast<size_t>(t - first_)].positions[0].y() - pelvis_target(t).y()));
    std::nth_element(heights.begin(), heights.begin() + static_cast<int64_t>(heights.size() / 2), heights.end());
    out_.pelvis_gap = heights[heights.size() / 2];
    for (int64_t t = first_; t <= last_; ++t)
      for (const int joint : kFootJoints)
        if (foot_down(t, joint))
          out_.slide =
              std::max(out_.slide, (found[static_cast<size_t>(t - first_)].positions[static_cast<size_t>(joint)] -
                                    poses_[static_cast<size_t>(t)].positions[static_cast<size_t>(joint)])
                                       .norm());
    out_.depth = std::max(0.0, depth_in(out_.clip, *chairs_.fresh_surface) - depth_in(clip_, *chairs_.old_surface));
  }

  const Clip& clip_;
  const BodyModel& body_ = builtin_body();
  Chairs chairs_;
  std::vector<refine::BodyBall> balls_;
  Reseated out_;
  refine::Trajectory start_;
  refine::Poses poses_;
  std::vector<Stay> stays_;
  std::vector<Hold> holds_;
  int64_t first_ = 0, last_ = 0;
  refine::Problem problem_;
};

/// How far the seat goes on from its middle along an axis: until its height changes by more than 4 cm.
double reach_of(const Chair& chair, const SceneQuery& surface, const Vector3d& axis) {
  constexpr int kSteps = 80;
  constexpr double kStep = 0.01, kFromAbove = 0.5;
  std::vector<float> from, down;
  for (int i = 0; i < kSteps; ++i) {
    const Vector3d p = chair.frame * Vector3d(axis * (i * kStep) + Vector3d(0, chair.seat_height + kFromAbove, 0));
    for (int a = 0; a < 3; ++a) from.push_back(static_cast<float>(p[a])), down.push_back(a == 1 ? -1.0F : 0.0F);
  }
  const RayHits hits =
      surface.cast(torch::tensor(from).view({-1, 3}).contiguous(), torch::tensor(down).view({-1, 3}).contiguous());
  double reach = 0;
  for (int i = 0, gap = 0; i < kSteps && gap < 6; ++i) {
    const bool level = hits.hit[i].item<bool>() && std::abs(hits.distances[i].item<double>() - kFromAbove) < 0.04;
    gap = level ? 0 : gap + 1;
    if (level) reach = i * kStep;
  }
  return reach;
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
                       double to_height) {
  const auto along = [](double v, double low, double high, double to_low, double to_high) {
    if (v <= low) return to_low + v - low;
    if (v >= high) return to_high + v - high;
    return to_low + (v - low) * (to_high - to_low) / std::max(high - low, 1e-6);
  };
  return {along(place.x(), from.right, from.left, to.right, to.left),
          place.y() < from_height ? place.y() * to_height / from_height : to_height + place.y() - from_height,
          along(place.z(), from.rear, from.front, to.rear, to.front)};
}

Reseated reseat(const Clip& clip, const Scene& scene, const Scene& chairs, const std::string& chair,
                bool lose_contacts) {
  const torch::NoGradGuard no_gradient;
  validate(clip, "clip");
  if (clip.skeleton.size() != kStandardJoints || !clip.rotations.defined() || !clip.contact.defined())
    throw Error("clip", "needs rotations and contacts on the standard skeleton");
  return Reseating(clip, scene, chairs, chair).run(lose_contacts);
}

}  // namespace inhabit::interact
