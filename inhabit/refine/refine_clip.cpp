#include "inhabit/refine/refine_clip.h"

#include <algorithm>
#include <cmath>

#include "inhabit/body/body_model.h"
#include "inhabit/error.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/refine/contacts.h"
#include "inhabit/refine/scene_terms.h"
#include "inhabit/refine/solve.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;
// A motion is believed no more closely than this: what contacts ask for must be possible.
constexpr double kLeastAngle = 0.3 * kDegree, kLeastPlace = 0.004;
constexpr double kRotationAcceleration = 15;  // rad/s^2, standard deviation of a joint that moves
constexpr double kPlaceAcceleration = 6;      // m/s^2
constexpr double kChange = 4;                 // m/s^2, of what is changed
constexpr double kContact = 0.001, kHeelContact = 0.004, kKept = 0.0003;  // metres
constexpr double kClear = 0.06, kClearWeight = 1e4;  // metres, 1 / m^2: the ball of a foot that goes
constexpr double kOutside = 0.003;                   // metres
constexpr double kLimit = 1 * kDegree;
constexpr double kReach = 0.05;  // metres from the scene within which it is minded
constexpr int64_t kWindow = 300, kOverlap = 30;
constexpr std::array<int, 4> kFootJoints = {10, 11, 7, 8};  // balls of the feet, then ankles

double inverse_square(double x) { return 1 / (x * x); }
double squared(double x) { return x * x; }

bool is_ball(int joint) { return joint >= 10; }

struct Foot {
  int joint;
  Track track;
  std::vector<double> floor;
  double standing;
  std::vector<Contact> contacts;
};

double smooth_between(double x, double low, double high) {
  const double u = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

/// Where no scene says: one floor under the lowest of the feet; y = 0 where that is near.
double flat_floor(const Poses& poses) {
  std::vector<double> heights;
  for (const BonesPose& pose : poses) heights.push_back(std::min(pose.positions[10].y(), pose.positions[11].y()));
  const auto at = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 20);
  std::nth_element(heights.begin(), at, heights.end());
  const double floor = *at - 0.02;
  return std::abs(floor) < 0.1 ? 0 : floor;
}

class Refinement {
 public:
  Refinement(Clip clip, const Scene& scene, const Options& options)
      : clip_(std::move(clip)),
        options_(options),
        surroundings_(scene),
        balls_(body_balls(builtin_body(), clip_.betas)) {}

  Result run() {
    base();
    Result out;
    out.noise_root = noise_.root;
    std::vector<double> sorted = noise_.rotations;
    std::nth_element(sorted.begin(), sorted.begin() + 11, sorted.end());
    out.noise_rotations = sorted[11];
    Trajectory found = solve_windows({2, 1e-3});
    if (options_.contacts) {
      find_contacts(posed(problem_.bones, found));
      for (const Foot& foot : feet_) out.contacts += static_cast<int64_t>(foot.contacts.size());
      add_feet();
    }
    planes_ = problem_.planes;
    for (int round = 0; round < 2; ++round) {
      problem_.initial = found;
      problem_.planes = planes_;
      const std::vector<PlaneTerm> scene =
          surroundings_.planes(balls_, kStandardJoints, posed(problem_.bones, found), kReach, inverse_square(kOutside));
      problem_.planes.insert(problem_.planes.end(), scene.begin(), scene.end());
      if (round > 0 && scene.empty()) break;
      found = solve_windows({6, 1e-3});
    }
    out.clip = clip_of(found, clip_);
    out.moved = (out.clip.joints - clip_.joints).norm(2, {2}).mean().item<double>();
    return out;
  }

 private:
  bool kept(int64_t frame) const { return problem_.fixed[static_cast<size_t>(frame)] != 0; }

  /// Nearness, smoothness, limits and what is kept.
  void base() {
    problem_.bones = bones_of(clip_.skeleton);
    problem_.rate = clip_.rate;
    problem_.start = trajectory_of(clip_);
    problem_.points = joint_points(kStandardJoints);
    for (const BodyBall& ball : balls_) problem_.points.push_back(ball.point);
    noise_ = noise_of(problem_.start);
    const auto frames = static_cast<size_t>(clip_.frames());
    problem_.fixed.assign(frames, 0);
    for (const int64_t frame : options_.keep_frames) problem_.fixed[static_cast<size_t>(frame)] = 1;
    const double per_frame = 30 / clip_.rate;  // sums over frames stand for integrals over time
    // Smoothing counts as much as there is noise to be taken away.
    std::vector<double> noisy(kStandardJoints);
    problem_.stay_near.rotations.resize(frames * kStandardJoints);
    problem_.stay_near.root.resize(frames);
    for (size_t j = 0; j < kStandardJoints; ++j) {
      const double sigma = std::max(kLeastAngle, noise_.rotations[j]);
      noisy[j] = squared(std::min(1.0, noise_.rotations[j] / sigma));
      for (size_t t = 0; t < frames; ++t)
        problem_.stay_near.rotations[t * kStandardJoints + j] = per_frame * inverse_square(sigma);
    }
    const double root = std::max(kLeastPlace, noise_.root);
    for (double& w : problem_.stay_near.root) w = per_frame * inverse_square(root);
    const double smooth = options_.smooth * per_frame;
    if (frames > 2) {
      problem_.smoothness.push_back({2, 0, smooth * inverse_square(kRotationAcceleration), {}, false, noisy});
      std::vector<double> root_only(kStandardJoints, 0);
      problem_.smoothness.push_back(
          {2,
           smooth * squared(std::min(1.0, noise_.root / root)) * inverse_square(kPlaceAcceleration),
           0,
           {},
           false,
           {}});
      problem_.smoothness.push_back({2, per_frame * inverse_square(kChange), 0, {}, true, {}});
    }
    const torch::Tensor limits = builtin_body().joint_limits;
    for (int64_t j = 0; j < kStandardJoints; ++j) {
      const auto side = [&](int64_t i) -> Vector3d {
        return {limits[j][0][i].item<double>(), limits[j][1][i].item<double>(), limits[j][2][i].item<double>()};
      };
      problem_.low.push_back(side(0));
      problem_.high.push_back(side(1));
    }
    problem_.limit_weight = per_frame * inverse_square(kLimit);
    const Poses poses = posed(problem_.bones, problem_.start);
    for (const int joint : options_.keep_joints)
      for (size_t t = 0; t < frames; ++t)
        problem_.places.push_back({static_cast<int64_t>(t),
                                   joint,
                                   poses[t].positions[static_cast<size_t>(joint)],
                                   Vector3d::Constant(inverse_square(kKept)),
                                   {}});
  }

  void find_contacts(const Poses& poses) {
    const double flat = flat_floor(poses);
    for (const int joint : kFootJoints) {
      Foot foot{joint, track_of(poses, joint), {}, 0, {}};
      foot.floor = surroundings_.floor_under(foot.track);
      for (double& f : foot.floor)
        if (std::isnan(f)) f = flat;
      foot.standing = standing_height(foot.track, foot.floor);
      ContactDetection detection;
      if (!is_ball(joint)) detection = {0.03, 0.25, 0.4, 0.1};
      foot.contacts = detect_contacts(joint, foot.track, foot.floor, foot.standing, clip_.rate, detection);
      feet_.push_back(std::move(foot));
    }
  }

  /// Where a contact holds its joint in each of its frames: at one place, that of a kept frame if it has one, or from
  /// each kept frame's place to the next one's.
  std::vector<Vector3d> footholds(const Contact& contact, const Foot& foot) const {
    const Poses start = posed(
        problem_.bones, Trajectory(problem_.start.begin() + contact.first, problem_.start.begin() + contact.last + 1));
    std::vector<int64_t> known;
    for (int64_t t = contact.first; t <= contact.last; ++t)
      if (kept(t)) known.push_back(t);
    const auto at = [&](int64_t t) { return start[static_cast<size_t>(t - contact.first)].positions[foot.joint]; };
    const Vector3d middle = contact_place(contact, foot.track);
    std::vector<Vector3d> out;
    for (int64_t t = contact.first; t <= contact.last; ++t) {
      const auto next = std::lower_bound(known.begin(), known.end(), t);
      if (known.empty()) {
        out.push_back(middle);
      } else if (next == known.begin()) {
        out.push_back(at(known.front()));
      } else if (next == known.end()) {
        out.push_back(at(known.back()));
      } else {
        const double part = static_cast<double>(t - *(next - 1)) / static_cast<double>(*next - *(next - 1));
        out.push_back((1 - part) * at(*(next - 1)) + part * at(*next));
      }
    }
    return out;
  }

  void add_feet() {
    const double per_frame = 30 / clip_.rate;
    for (const Foot& foot : feet_) {
      const double sigma = is_ball(foot.joint) ? kContact : kHeelContact;
      std::vector<char> stands(foot.track.size(), 0);
      for (const Contact& contact : foot.contacts) {
        const std::vector<Vector3d> places = footholds(contact, foot);
        for (int64_t t = contact.first; t <= contact.last; ++t) {
          stands[static_cast<size_t>(t)] = 1;
          problem_.places.push_back({t,
                                     foot.joint,
                                     places[static_cast<size_t>(t - contact.first)],
                                     Vector3d::Constant(per_frame * inverse_square(sigma)),
                                     {}});
        }
      }
      if (!is_ball(foot.joint)) continue;
      for (size_t t = 0; t < foot.track.size(); ++t) {
        if (stands[t]) continue;
        const auto frame = static_cast<int64_t>(t);
        // Not under the floor; and a foot that goes does not drag along it.
        problem_.planes.push_back({frame, foot.joint, Vector3d::UnitY(),
                                   foot.floor[t] + std::clamp(foot.standing - 0.01, 0.0, 0.02),
                                   per_frame * inverse_square(kContact), false});
        const size_t before = t == 0 ? t : t - 1, after = std::min(t + 1, foot.track.size() - 1);
        Vector3d step = foot.track[after] - foot.track[before];
        step.y() = 0;
        const double speed = step.norm() * clip_.rate / static_cast<double>(std::max<size_t>(1, after - before));
        const double going = smooth_between(speed, 0.5, 0.8);
        if (going > 0 && foot.track[t].y() - foot.floor[t] < kClear)
          problem_.planes.push_back(
              {frame, foot.joint, Vector3d::UnitY(), foot.floor[t] + kClear, per_frame * going * kClearWeight, false});
      }
    }
  }

  /// Long motions in windows that overlap; the frames of an overlap are those of the window before, which the next one
  /// goes on from.
  Trajectory solve_windows(const SolveOptions& options) { return solve(problem_, options).trajectory; }

  Clip clip_;
  const Options& options_;
  Surroundings surroundings_;
  std::vector<BodyBall> balls_;
  Problem problem_;
  NoiseLevel noise_;
  std::vector<Foot> feet_;
  std::vector<PlaneTerm> planes_;
};

}  // namespace

Result refine(const Clip& clip, const Scene& scene, const Options& options, const std::string& subject) {
  if (!(options.smooth >= 0 && options.smooth <= 1e6)) throw Error("smooth", "is not from 0 to a million");
  for (const int64_t frame : options.keep_frames)
    if (frame < 0 || frame >= clip.frames())
      throw Error("keep", "there is no frame " + std::to_string(frame) + " in " + subject + ", which has " +
                              std::to_string(clip.frames()));
  for (const int joint : options.keep_joints)
    if (joint < 0 || joint >= kStandardJoints) throw Error("keep", "there is no joint " + std::to_string(joint));
  return Refinement(retarget(clip, subject), scene, options).run();
}

}  // namespace inhabit::refine
