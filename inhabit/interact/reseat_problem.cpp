#include "inhabit/interact/reseat_problem.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "inhabit/body/body_model.h"
#include "inhabit/body/joint_limits.h"
#include "inhabit/math/quantile.h"
#include "inhabit/refine/solve.h"
#include "inhabit/refine/weights.h"
#include "inhabit/scene/point_rows.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;
using refine::weight_of;

constexpr double kExactPlace = 0.001, kWristPlace = 0.012, kSwingPlace = 0.01;  // metres
constexpr double kPelvisHeight = 0.004, kPelvisPlace = 0.03;
constexpr double kSkin = 0.002, kSkinDepth = 0.009;       // metres: how exactly skin stays above that depth
constexpr double kLeastSunk = -0.008, kMostSunk = 0.004;  // metres: skin of a seated pelvis against the seat
constexpr int kRounds = 5;
constexpr double kChangedAround = 1.5;  // seconds before and after that change too

/// Distance of a place to the line from a to b.
double off_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const double along = std::clamp((p - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-9), 0.0, 1.0);
  return (p - a - along * (b - a)).norm();
}

std::vector<Hold> holds_at(const ChairPair& chairs, const Clip& clip) {
  std::vector<Hold> holds;
  if (!clip.hand_targets.defined()) return holds;
  const torch::Tensor targets = clip.hand_targets.to(torch::kDouble).contiguous();
  const auto h = targets.accessor<double, 3>();
  for (int side = 0; side < 2; ++side)
    for (int64_t t = 0; t < clip.frames(); ++t) {
      if (h[t][side][3] < 0.5) continue;
      const Vector3d point(h[t][side][0], h[t][side][1], h[t][side][2]);
      const bool goes_on = !holds.empty() && holds.back().side == side && holds.back().last == t - 1 &&
                           (holds.back().points.back() - point).norm() < 0.03;
      if (!goes_on) holds.push_back({side, t, t, {}, {}});
      holds.back().last = t;
      holds.back().points.push_back(point);
    }
  std::erase_if(holds, [&](const Hold& hold) {  // of other furniture
    return chairs.old_surface->closest(point_rows({hold.points.front()})).distances[0].item<double>() > 0.05;
  });
  return holds;
}

/// How far the sitting skin is over the old seat, median of a stay; negative inside.
double sunk(const ChairPair& chairs, const refine::Skin& skin, const std::vector<int>& owner,
            const refine::Trajectory& trajectory, const refine::Poses& poses, const Stay& stay) {
  constexpr double kBelow = 0.14;  // metres from the pelvis, seen from above
  std::vector<double> least;
  for (int64_t t = stay.first; t <= stay.last; t += 5) {
    const auto i = static_cast<size_t>(t);
    const refine::PosedSkin posed = refine::pose_skin(skin, trajectory[i], poses[i]);
    std::vector<Vector3d> under;
    for (size_t v = 0; v < owner.size(); ++v) {
      const Vector3d off = posed.vertices[v] - poses[i].positions[0];
      if (sits_on(owner[v]) && std::hypot(off.x(), off.z()) < kBelow && off.y() < 0) under.push_back(posed.vertices[v]);
    }
    if (under.empty()) continue;
    least.push_back(chairs.old_surface->signed_distance(point_rows(under)).min().item<double>());
  }
  return least.empty() ? 0 : median(std::move(least));
}

}  // namespace

std::vector<int> skin_owners() {
  const torch::Tensor most = builtin_body().skin_weights.argmax(1).contiguous();
  return {most.data_ptr<int64_t>(), most.data_ptr<int64_t>() + most.numel()};
}

ChairStays stays_on(const ChairPair& chairs, const Clip& clip) {
  ChairStays out{chairs.old.name, {}, holds_at(chairs, clip), clip.frames(), -1};
  for (const Stay& stay : stays_of(clip)) {
    const Vector3d away = chairs.old.frame.inverse() * stay.rest;
    if (std::hypot(away.x(), away.z()) > 1) continue;  // on something else
    out.stays.push_back(stay);
    out.first = std::min(out.first, stay.down);
    out.last = std::max(out.last, stay.rises ? stay.risen : clip.frames() - 1);
  }
  for (const Hold& hold : out.holds) {
    out.first = std::min(out.first, hold.first);
    out.last = std::max(out.last, hold.last);
  }
  const auto around = static_cast<int64_t>(kChangedAround * clip.rate);
  out.first = std::max<int64_t>(0, out.first - around);
  out.last = std::min(clip.frames() - 1, out.last + around);
  return out;
}

ReseatProblem::ReseatProblem(const ChairPair& chairs, const Insides& insides, const Clip& clip, const Scene& scene,
                             const ChairStays& stays, bool frame_by_frame)
    : chairs_(chairs),
      insides_(insides),
      clip_(clip),
      stays_(stays),
      surroundings_(scene),
      skin_(refine::skin_of(builtin_body(), clip.betas)),
      balls_(refine::body_balls(builtin_body(), clip.betas)),
      owner_(skin_owners()),
      vertex_point_(owner_.size(), -1),
      start_(refine::trajectory_of(clip)),
      before_(refine::posed(bones_of(clip.skeleton), start_)) {
  // What sits and touches is minded by its skin: the balls there are thicker than it is.
  std::erase_if(balls_, [](const refine::BodyBall& ball) {
    const int joint = ball.point.front().joint;
    return sits_on(joint) || joint >= 18;
  });
  set_up(frame_by_frame);
  add_pelvis();
  add_feet();
  for (const Hold& hold : stays_.holds)
    if (hold.to) add_hold(hold);
  given_places_ = problem_.places.size();
}

void ReseatProblem::set_up(bool frame_by_frame) {
  const auto frames = static_cast<size_t>(stays_.last - stays_.first + 1);
  problem_.bones = bones_of(clip_.skeleton);
  problem_.rate = clip_.rate;
  problem_.start.assign(start_.begin() + stays_.first, start_.begin() + stays_.last + 1);
  problem_.initial = problem_.start;
  problem_.points = refine::joint_points(kStandardJoints);
  for (const refine::BodyBall& ball : balls_) problem_.points.push_back(ball.point);
  const double per_frame = 30 / clip_.rate;
  problem_.stay_near.rotations.assign(frames * kStandardJoints, per_frame * weight_of(0.2));
  problem_.stay_near.root.assign(frames, per_frame * weight_of(0.6));
  problem_.fixed.assign(frames, 0);
  if (!frame_by_frame) {
    std::vector<double> root_alone(kStandardJoints, 0);
    root_alone[0] = 1;
    problem_.smoothness.push_back({2, per_frame * weight_of(2), 0, {}, true, root_alone});
    problem_.smoothness.push_back({2, 0, per_frame * weight_of(2), {}, true, {}});
    for (size_t t = 0; t < 3 && frames > 8; ++t) {
      if (stays_.first > 0) problem_.fixed[t] = 1;
      if (stays_.last + 1 < clip_.frames()) problem_.fixed[frames - 1 - t] = 1;
    }
  }
  problem_.limits = joint_limits(builtin_body(), kStandardJoints);
  problem_.limit_weight = weight_of(0.003);
}

refine::Trajectory ReseatProblem::solve() {
  for (int round = 0; round < kRounds; ++round) {
    if (round > 0) {  // what is near and deep is seen along the way
      const refine::Poses poses = refine::posed(problem_.bones, problem_.initial);
      problem_.places.resize(given_places_);
      problem_.planes = surroundings_.planes(balls_, kStandardJoints, poses, problem_.rate, 0.05, weight_of(0.003));
      add_hands_on_thighs(poses);
      add_skin(poses);
    }
    problem_.initial = refine::solve(problem_, {8, 1e-3}).trajectory;
  }
  refine::Trajectory whole = start_;
  std::copy(problem_.initial.begin(), problem_.initial.end(), whole.begin() + stays_.first);
  return whole;
}

void ReseatProblem::add_place(int64_t frame, int point, const Vector3d& target, const Vector3d& sigma) {
  problem_.places.push_back({frame - stays_.first, point, target, sigma.cwiseProduct(sigma).cwiseInverse(), {}});
}

/// As much higher as the seat is, its skin on it; back against a back rest that it leaned on, and out of one that is
/// nearer.
void ReseatProblem::add_pelvis() {
  for (const Stay& stay : stays_.stays) {
    const double over = sunk(chairs_, skin_, owner_, start_, before_, stay);
    const double lift = chairs_.rise() + std::clamp(over, kLeastSunk, kMostSunk) - over;
    const Eigen::Isometry3d to_chair = chairs_.old.frame.inverse();
    const double deeper = chairs_.fresh_seat.rear - chairs_.old_seat.rear;  // positive: the back rest is nearer
    const bool leans =
        clip_.contact.slice(0, stay.first, stay.last + 1).index({torch::indexing::Slice(), 6}).sum().item<double>() > 0;
    const double behind = (to_chair * stay.rest).z() - chairs_.old_seat.rear;
    const double needed = std::max(0.0, deeper - std::max(0.0, behind - 0.12));
    const double shift = leans ? std::clamp(deeper, -0.1, 0.1) : std::min(needed, 0.15);
    const Vector3d change = chairs_.old.frame.linear() * Vector3d(0, lift, shift);
    for (int64_t t = stay.first; t <= stay.last; ++t)
      add_place(t, 0, before_[static_cast<size_t>(t)].positions[0] + change,
                {kPelvisPlace, kPelvisHeight, kPelvisPlace});
  }
}

void ReseatProblem::add_feet() {
  for (int64_t t = stays_.first; t <= stays_.last; ++t)
    for (const int64_t joint : kFootJoints)
      add_place(t, static_cast<int>(joint), before_[static_cast<size_t>(t)].positions[static_cast<size_t>(joint)],
                Vector3d::Constant(clip_.contact[t][joint].item<float>() > 0.5F ? kExactPlace : kSwingPlace));
}

/// The touched point of the palm exactly, the wrist as it lay over it.
void ReseatProblem::add_hold(const Hold& hold) {
  const auto wrist = 20 + static_cast<size_t>(hold.side);
  for (int64_t t = hold.first; t <= hold.last; ++t) {
    const auto k = static_cast<size_t>(t - hold.first);
    const BonesPose& before = before_[static_cast<size_t>(t)];
    const Vector3d away = before.positions[wrist] - hold.points[k];
    problem_.points.push_back({{static_cast<int>(wrist), 1, before.rotations[wrist].conjugate() * -away}});
    add_place(t, static_cast<int>(wrist), hold.to->points[k] + hold.to->tilt * away, Vector3d::Constant(kWristPlace));
    add_place(t, static_cast<int>(problem_.points.size()) - 1, hold.to->points[k], Vector3d::Constant(kExactPlace));
  }
}

/// Hands that lie on a thigh go with it.
void ReseatProblem::add_hands_on_thighs(const refine::Poses& poses) {
  constexpr double kOn = 0.15, kOff = 0.2;  // metres from the thigh's bone
  const auto held = [&](int side, int64_t t) {
    return std::any_of(stays_.holds.begin(), stays_.holds.end(), [&](const Hold& hold) {
      return hold.to && hold.side == side && t >= hold.first && t <= hold.last;
    });
  };
  for (const Stay& stay : stays_.stays)
    for (int64_t t = stay.first; t <= stay.last; ++t)
      for (int side = 0; side < 2; ++side) {
        const auto wrist = 20 + static_cast<size_t>(side);
        const BonesPose &before = before_[static_cast<size_t>(t)], &now = poses[static_cast<size_t>(t - stays_.first)];
        size_t thigh = 1;
        double nearest = 1e9;
        for (const size_t hip : {size_t{1}, size_t{2}}) {
          const double off = off_segment(before.positions[wrist], before.positions[hip], before.positions[hip + 3]);
          if (off < nearest) nearest = off, thigh = hip;
        }
        if (nearest > kOff || held(side, t)) continue;
        const Vector3d own = before.rotations[thigh].conjugate() * (before.positions[wrist] - before.positions[thigh]);
        const double sigma = nearest < kOn ? 0.01 : 0.01 + 0.5 * (nearest - kOn);
        add_place(t, static_cast<int>(wrist), now.positions[thigh] + now.rotations[thigh] * own,
                  Vector3d::Constant(sigma));
      }
}

int ReseatProblem::skin_point(size_t vertex) {
  if (vertex_point_[vertex] < 0) {
    refine::Point point;
    for (int k = skin_.first[vertex]; k < skin_.first[vertex + 1]; ++k) {
      const refine::Skin::Weight& w = skin_.weights[static_cast<size_t>(k)];
      point.push_back({w.joint, w.weight, skin_.rest[vertex] - skin_.joints[static_cast<size_t>(w.joint)]});
    }
    vertex_point_[vertex] = static_cast<int>(problem_.points.size());
    problem_.points.push_back(point);
  }
  return vertex_point_[vertex];
}

/// Skin that is in the new chair, the deepest of each joint's, stays above the surface but for what gives.
void ReseatProblem::add_skin(const refine::Poses& poses) {
  constexpr double kApart = 0.04;  // metres between vertices that are asked
  constexpr size_t kOfJoint = 4;
  for (size_t t = 0; t < poses.size(); ++t) {
    if (problem_.fixed[t] != 0) continue;
    const refine::PosedSkin posed = refine::pose_skin(skin_, problem_.initial[t], poses[t]);
    const Insides::Deep deep = insides_.deep(point_rows(posed.vertices));
    std::vector<size_t> order(deep.rows.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::sort(order.begin(), order.end(),
              [&](size_t a, size_t b) { return std::pair(-deep.depths[a], a) < std::pair(-deep.depths[b], b); });
    std::array<std::vector<Vector3d>, kStandardJoints> taken;
    for (const size_t i : order) {
      const auto vertex = static_cast<size_t>(deep.rows[i]);
      const Vector3d& place = posed.vertices[vertex];
      std::vector<Vector3d>& others = taken[static_cast<size_t>(owner_[vertex])];
      if (others.size() >= kOfJoint ||
          std::any_of(others.begin(), others.end(), [&](const Vector3d& o) { return (o - place).norm() < kApart; }))
        continue;
      others.push_back(place);
      add_skin_plane(static_cast<int64_t>(t), vertex, place, deep.places[i]);
    }
  }
}

void ReseatProblem::add_skin_plane(int64_t frame, size_t vertex, const Vector3d& place, Vector3d surface) {
  Vector3d normal = surface - place;
  if (normal.norm() < 1e-4) return;
  normal.normalize();
  const double seat = chairs_.fresh.frame.translation().y() + chairs_.fresh.seat_height;
  if (sits_on(owner_[vertex]) && normal.y() < 0.3 && place.y() < seat && place.y() > seat - 0.08) {
    // Through a thin board or off its edge the nearest way out is not the way up.
    surface.y() = seat;
    normal = Vector3d::UnitY();
  }
  problem_.planes.push_back(
      {frame, skin_point(vertex), normal, normal.dot(surface) - kSkinDepth, weight_of(kSkin), false});
}

}  // namespace inhabit::interact
