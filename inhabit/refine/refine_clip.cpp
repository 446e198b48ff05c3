#include "inhabit/refine/refine_clip.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <mutex>
#include <numeric>
#include <sstream>

#include "inhabit/body/body_model.h"
#include "inhabit/body/joint_limits.h"
#include "inhabit/body/palm.h"
#include "inhabit/error.h"
#include "inhabit/math/quantile.h"
#include "inhabit/math/smooth_step.h"
#include "inhabit/motion/floor.h"
#include "inhabit/motion/landmarks.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/motion/transfer.h"
#include "inhabit/refine/contacts.h"
#include "inhabit/refine/noise.h"
#include "inhabit/refine/scene_terms.h"
#include "inhabit/refine/skin_terms.h"
#include "inhabit/refine/solve.h"
#include "inhabit/refine/terms.h"
#include "inhabit/refine/weights.h"
#include "inhabit/scene/objects.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

/// How closely a motion is believed, and what is taken for a contact in it.
struct Belief {
  // Less noise than this is none, and no motion is believed more closely, as what contacts ask for must be possible.
  double angle, place;      // radians of each rotation, metres of the root
  double foothold;          // metres: how near a contact stays to where it was found
  double tolerance;         // of the last steps, see SolveOptions
  ContactDetection detect;  // of balls of the feet
  double glide = 0;         // metres from where it stands that a low foot is still taken for standing
};
constexpr Belief kRecorded = {0.3 * kDegree, 0.003, 0.001, 1e-3, {}};
constexpr Belief kGenerated = {3 * kDegree, 0.02, 0.02, 1e-3, {0.07, 0.9, 1.2, 0.15, 0.13}, 0.12};
// Metres that a ball rises before it goes, the last frame first, a thirtieth of a second apart.
constexpr std::array<double, 4> kToeOff = {0.035, 0.015, 0.005, 0};
constexpr double kToeOffStep = 1.0 / 30, kLeastStand = 6;  // seconds; steps: a contact that is shorter has no toe-off
constexpr double kGlideHeight = 0.035;                     // metres over where it stands: so low a foot slides

constexpr double kChange = 4;                             // m/s^2, of what is changed
constexpr double kUsualJerk = 70;                         // m/s^3: the jerk found where kPlaceJerk is right
constexpr double kCalm = 1, kLively = 2.2;                // how far the motion's own jerk is followed
constexpr double kContact = 0.001, kHeelContact = 0.004;  // metres: how exactly balls and heels stay
// Metres: how exactly a palm stays from frame to frame, at the end of the longest chain of joints, and on its surface.
constexpr double kPalm = 0.0003, kSurface = 0.0005;
constexpr double kFoothold = 0.01;                    // metres: no foothold is freer for noise
constexpr double kGiven = 0.0003;                     // metres
constexpr double kClear = 0.06, kClearPlace = 0.002;  // metres: the ball of a foot that goes is so high
constexpr double kResting = 0.3, kGoing = 0.6;        // m/s: it may be on the floor; it is to be kClear above
constexpr double kOutside = 0.003, kReach = 0.05;     // metres; from the scene within which it is minded
constexpr double kSkin = 0.002;                       // metres: how exactly Options::skin_depth holds
constexpr double kLimit = 6 * kDegree;                // beyond the body's limits; recordings go there too
constexpr int kRounds = 2, kSkinRounds = 3;           // skin that has come out at another face is seen in the third
constexpr int64_t kBefore = 10;                       // observed frames that a continuation goes on from
constexpr double kSoftFoot = 2;                  // m/s^2: no key poses have to be met, so that feet may land softly
constexpr int64_t kWindow = 300, kOverlap = 30;  // frames
constexpr std::array<int, 4> kBallsThenAnkles = {10, 11, 7, 8};
constexpr int kLeftWrist = 20;

double squared(double x) { return x * x; }

struct Foot {
  int joint;
  Track track;
  std::vector<double> floor;
  double standing;
  std::vector<Contact> contacts;
};

/// A hand on a surface of the scene.
struct Rest {
  Contact contact;
  int point;  // of the problem: the palm
  SurfacePlace at;
};

/// (frames, 2, 4) as Clip::hand_targets.
torch::Tensor targets_of(const std::vector<GivenContact>& hands, int64_t frames) {
  torch::Tensor out = torch::zeros({frames, 2, 4});
  auto target = out.accessor<float, 3>();
  for (const GivenContact& hand : hands)
    for (int64_t t = hand.first; t <= hand.last; ++t) {
      for (int i = 0; i < 3; ++i) target[t][hand.joint - kLeftWrist][i] = static_cast<float>(hand.place[i]);
      target[t][hand.joint - kLeftWrist][3] = 1;
    }
  return out;
}

/// Where no scene says: one floor under the lowest of the feet, from which it is then found when they stand; y = 0
/// where that is near.
double flat_floor(const Poses& poses) {
  std::vector<double> lower_balls;
  for (const BonesPose& pose : poses) lower_balls.push_back(std::min(pose.positions[10].y(), pose.positions[11].y()));
  const double floor = floor_under_lowest(std::move(lower_balls));
  return std::abs(floor) < 0.1 ? 0 : floor;
}

/// Frames [first, last) of the windows that a motion is solved in. More than two are so many that two and four threads
/// have the same to do.
std::vector<std::array<int64_t, 2>> windows_of(int64_t frames) {
  if (frames <= kWindow + kOverlap) return {{0, frames}};
  constexpr int64_t kEach = kWindow - kOverlap;
  int64_t count = (frames - kOverlap + kEach - 1) / kEach;
  if (count > 2) count = (count + 3) / 4 * 4;
  const auto begin = [&](int64_t window) { return (frames - kOverlap) * window / count; };
  std::vector<std::array<int64_t, 2>> out;
  for (int64_t i = 0; i < count; ++i) out.push_back({begin(i), begin(i + 1) + kOverlap});
  return out;
}

/// Frames [first, last) of a problem, begun at `from`.
Problem part_of(const Problem& problem, const Trajectory& from, int64_t first, int64_t last) {
  const auto cut = [&](const auto& values, int64_t each) {
    return std::decay_t<decltype(values)>(values.begin() + first * each, values.begin() + last * each);
  };
  Problem out;
  out.bones = problem.bones;
  out.rate = problem.rate;
  out.points = problem.points;
  out.smoothness = problem.smoothness;
  out.limits = problem.limits;
  out.limit_weight = problem.limit_weight;
  out.start = cut(problem.start, 1);
  out.initial = cut(from, 1);
  out.fixed = cut(problem.fixed, 1);
  out.stay_near.rotations = cut(problem.stay_near.rotations, problem.bones.size());
  out.stay_near.root = cut(problem.stay_near.root, 1);
  const auto pick = [&](const auto& terms, auto& to) {
    for (const auto& term : terms)
      if (term.frame >= first && term.frame < last) to.push_back(term), to.back().frame -= first;
  };
  pick(problem.places, out.places);
  pick(problem.planes, out.planes);
  for (const HoldTerm& hold : problem.holds) {
    if (hold.frame < first || hold.frame + 1 >= last) continue;
    out.holds.push_back(hold);
    out.holds.back().frame -= first;
  }
  return out;
}

class Refinement {
 public:
  Refinement(Clip clip, const Surroundings& surroundings, const Options& options)
      : clip_(std::move(clip)),
        options_(options),
        belief_(options.generated ? kGenerated : kRecorded),
        surroundings_(surroundings),
        balls_(body_balls(builtin_body(), clip_.betas)) {
    if (options.skin_depth) flesh_.emplace(builtin_body(), clip_.betas, balls_);
  }

  Result run() {
    base();
    Result out;
    out.noise_root = levels_.root;
    out.noise_rotations = median(levels_.rotations);
    Trajectory found = smoothed_ ? solve_windows({2, 1e-3}) : problem_.start;  // smooth enough to see contacts in
    if (options_.contacts) {
      find_contacts(posed(problem_.bones, found));
      lift_to_floor(found);
      for (const Foot& foot : feet_) out.contacts += static_cast<int64_t>(foot.contacts.size());
      add_footholds();
      find_rests(posed(problem_.bones, found));
      add_rests();
    }
    // Where the scene is near and feet go low is seen along the way.
    for (int round = 0; round < rounds(); ++round) {
      problem_.initial = found;
      const Poses poses = posed(problem_.bones, found);
      problem_.planes = surroundings_.planes(balls_, kStandardJoints, poses, clip_.rate, kReach, weight_of(kOutside));
      if (flesh_ && surroundings_.solid() != nullptr) {
        const std::vector<PlaneTerm> skin =
            flesh_->planes(*surroundings_.solid(), poses, *options_.skin_depth, weight_of(kSkin), problem_.points);
        problem_.planes.insert(problem_.planes.end(), skin.begin(), skin.end());
      }
      add_clearance(poses);
      add_rest_planes();
      found = solve_windows({3, belief_.tolerance});
    }
    out.before = clip_;
    out.clip = clip_of(found, clip_);
    for (const Rest& rest : rests_)
      out.hands.push_back({rest.contact.joint, palm_offset(rest.contact.joint - kLeftWrist).cast<double>(),
                           rest.at.place, rest.contact.first, rest.contact.last});
    if (!out.hands.empty() && !out.clip.hand_targets.defined())
      out.clip.hand_targets = targets_of(out.hands, clip_.frames());
    out.moved = (out.clip.joints - clip_.joints).norm(2, {2}).mean().item<double>();
    return out;
  }

 private:
  int rounds() const { return flesh_ ? kSkinRounds : kRounds; }
  bool kept(int64_t frame) const { return problem_.fixed[static_cast<size_t>(frame)] != 0; }

  /// Nearness, smoothness, limits and what is kept.
  void base() {
    problem_.bones = bones_of(clip_.skeleton);
    problem_.rate = clip_.rate;
    problem_.start = trajectory_of(clip_);
    problem_.points = joint_points(kStandardJoints);
    for (const BodyBall& ball : balls_) problem_.points.push_back(ball.point);
    levels_ = levels_of(problem_.bones, problem_.start, clip_.rate);
    const auto frames = static_cast<size_t>(clip_.frames());
    problem_.fixed.assign(frames, 0);
    for (const int64_t frame : options_.keep_frames) problem_.fixed[static_cast<size_t>(frame)] = 1;
    const double per_frame = 30 / clip_.rate;  // sums over frames stand for integrals over time
    problem_.stay_near.rotations.resize(frames * kStandardJoints);
    problem_.stay_near.root.resize(frames);
    // Smoothing counts as much as there is noise to be taken away, and the less the livelier the motion is.
    const double liveliness = std::clamp(levels_.jerk / kUsualJerk, kCalm, kLively);
    std::vector<double> noisy(kStandardJoints);
    for (size_t j = 0; j < kStandardJoints; ++j) {
      const double sigma = std::max(belief_.angle, levels_.rotations[j]);
      noisy[j] = 1 - squared(belief_.angle / sigma);
      for (size_t t = 0; t < frames; ++t)
        problem_.stay_near.rotations[t * kStandardJoints + j] = per_frame * weight_of(sigma);
    }
    const double root = std::max(belief_.place, levels_.root), place = std::max(belief_.place, levels_.place);
    const bool rotations_smoothed = std::any_of(noisy.begin(), noisy.end(), [](double part) { return part > 0; });
    const bool places_smoothed = place > belief_.place;
    smoothed_ = rotations_smoothed || places_smoothed;
    for (double& w : problem_.stay_near.root) w = per_frame * weight_of(root);
    const double smooth = options_.smooth * per_frame;
    if (frames > 3) {
      const double of_places = smooth * (1 - squared(belief_.place / place)) * weight_of(liveliness * kPlaceJerk);
      // Jerk ties frames that are three apart, which nearly doubles what a step costs: only where there is noise.
      if (rotations_smoothed)
        problem_.smoothness.push_back({3, 0, smooth * weight_of(liveliness * kRotationJerk), {}, false, noisy});
      std::vector<double> free(kStandardJoints, 1);  // what is kept is as smooth as it is
      for (const int joint : options_.keep_joints) free[static_cast<size_t>(joint)] = 0;
      if (places_smoothed) problem_.smoothness.push_back({3, of_places, 0, {}, false, free});
      std::vector<double> changes(kStandardJoints, 1);
      for (const int joint : kBallsThenAnkles)
        changes[static_cast<size_t>(joint)] = squared(kChange / options_.foot_change);
      problem_.smoothness.push_back({2, per_frame * weight_of(kChange), 0, {}, true, changes});
    }
    problem_.limits = joint_limits(builtin_body(), kStandardJoints);
    problem_.limit_weight = per_frame * weight_of(kLimit);
    const Poses poses = posed(problem_.bones, problem_.start);
    for (const GivenContact& contact : options_.given) {
      int point = contact.joint;
      if (!contact.offset.isZero()) {
        point = static_cast<int>(problem_.points.size());
        problem_.points.push_back({Attachment{contact.joint, 1, contact.offset}});
      }
      for (int64_t t = contact.first; t <= contact.last; ++t)
        problem_.places.push_back({t, point, contact.place, Vector3d::Constant(per_frame * weight_of(kGiven)), {}});
    }
    for (const int joint : options_.keep_joints)
      for (size_t t = 0; t < frames; ++t)
        problem_.places.push_back({static_cast<int64_t>(t),
                                   joint,
                                   poses[t].positions[static_cast<size_t>(joint)],
                                   Vector3d::Constant(weight_of(options_.keep_within)),
                                   {}});
  }

  /// What Options::feet says of a joint.
  std::vector<float> predicted(int joint) const {
    const auto column = std::find(kFootJoints.begin(), kFootJoints.end(), joint) - kFootJoints.begin();
    const torch::Tensor of_joint = options_.feet.select(1, column).to(torch::kFloat32).contiguous();
    return {of_joint.data_ptr<float>(), of_joint.data_ptr<float>() + of_joint.numel()};
  }

  void find_contacts(const Poses& poses) {
    const double flat = flat_floor(poses);
    for (const int joint : kBallsThenAnkles) {
      Foot foot{joint, track_of(poses, joint), {}, 0, {}};
      foot.floor = surroundings_.floor_under(foot.track);
      for (double& f : foot.floor)
        if (std::isnan(f)) f = flat;
      foot.standing = standing_height(foot.track, foot.floor);
      const ContactDetection& detect = is_ball(joint) ? belief_.detect : kHeelDetection;
      if (options_.feet.defined()) {
        foot.contacts =
            predicted_contacts(joint, predicted(joint), foot.track, foot.floor, foot.standing, clip_.rate, detect);
      } else {
        foot.contacts = detect_contacts(joint, foot.track, foot.floor, foot.standing, clip_.rate, detect);
        if (is_ball(joint) && belief_.glide > 0)
          extend_contacts(foot.contacts, foot.track, foot.floor, foot.standing, kGlideHeight, belief_.glide);
      }
      feet_.push_back(std::move(foot));
    }
  }

  /// A motion whose feet stand under the scene's floor is too low as a whole, where nothing of it is to be kept.
  void lift_to_floor(Trajectory& found) {
    double low = 0;
    for (const Foot& foot : feet_)
      if (is_ball(foot.joint)) low = std::max(low, -foot.standing);
    if (low < kContact || !options_.keep_frames.empty() || !options_.keep_joints.empty()) return;
    for (Trajectory* trajectory : {&problem_.start, &found})
      for (FramePose& pose : *trajectory) pose.trans.y() += low;
    for (Foot& foot : feet_) {
      foot.standing += low;
      for (Vector3d& place : foot.track) place.y() += low;
    }
  }

  /// Metres that a contact's place is known to, which stays to `still` metres: as well as the root.
  double nearness(double still) const {
    const double known = levels_.root > belief_.place ? std::min(levels_.root, kFoothold) : 0;
    return std::max({still, belief_.foothold, known});
  }

  bool has_kept_frame(const Contact& contact) const {
    return std::any_of(problem_.fixed.begin() + contact.first, problem_.fixed.begin() + contact.last + 1,
                       [](char fixed) { return fixed != 0; });
  }

  /// Contacts of hands with the scene. Without one there are none: hands that hang or lie in a lap stay as still as
  /// those that rest on something, and only a surface tells them apart. What touches in a network's motion is given, by
  /// who predicts it: contacts found in it made none of the systems' figures better.
  void find_rests(const Poses& poses) {
    if (!options_.hands || options_.generated || surroundings_.empty()) return;
    for (const int side : {0, 1}) {
      const int wrist = kLeftWrist + side;
      const auto is_wrist = [&](int joint) { return joint == wrist; };
      // Who gives a hand's contacts, or keeps it, has said where it is.
      if (std::any_of(options_.keep_joints.begin(), options_.keep_joints.end(), is_wrist) ||
          std::any_of(options_.given.begin(), options_.given.end(),
                      [&](const GivenContact& contact) { return is_wrist(contact.joint); }))
        continue;
      const Point palm = {Attachment{wrist, 1, palm_offset(side).cast<double>()}};
      Track track;
      for (const BonesPose& pose : poses) track.push_back(place_of(palm, pose));
      track = smoothed(track, clip_.rate, kPalmSmoothing);
      std::vector<double> distances;
      for (const SurfacePlace& surface : surroundings_.surfaces_near(track)) distances.push_back(surface.distance);
      const std::vector<Contact> contacts = detect_palm_contacts(wrist, track, distances, clip_.rate);
      if (contacts.empty()) continue;
      Track places;
      for (const Contact& contact : contacts) places.push_back(contact_place(contact, track));
      const std::vector<SurfacePlace> surfaces = surroundings_.surfaces_near(places);
      const auto point = static_cast<int>(problem_.points.size());
      problem_.points.push_back(palm);
      for (size_t i = 0; i < contacts.size(); ++i) rests_.push_back({contacts[i], point, surfaces[i]});
    }
  }

  /// A palm stays at one place of its surface, near to where it was found to rest.
  void add_rests() {
    const double per_frame = 30 / clip_.rate, near = nearness(kContact);
    for (const Rest& rest : rests_) {
      const Contact& contact = rest.contact;
      const std::vector<Vector3d> places = footholds(contact, rest.point, rest.at.place);
      for (int64_t t = contact.first; t <= contact.last; ++t)
        problem_.places.push_back({t,
                                   rest.point,
                                   places[static_cast<size_t>(t - contact.first)],
                                   Vector3d::Constant(per_frame * weight_of(near)),
                                   {}});
      for (int64_t t = contact.first; t < contact.last; ++t)
        problem_.holds.push_back({t, rest.point, Vector3d::Constant(per_frame * weight_of(kPalm))});
    }
  }

  /// The surfaces that palms are on. Where a kept frame says where a palm is, it may be beside the surface.
  void add_rest_planes() {
    const double per_frame = 30 / clip_.rate;
    for (const Rest& rest : rests_) {
      if (has_kept_frame(rest.contact)) continue;
      for (int64_t t = rest.contact.first; t <= rest.contact.last; ++t)
        problem_.planes.push_back(
            {t, rest.point, rest.at.normal, rest.at.normal.dot(rest.at.place), per_frame * weight_of(kSurface), true});
    }
  }

  /// Where a contact holds its point in each of its frames: at `middle`, at a kept frame's place if it has one, or from
  /// each kept frame's place to the next one's.
  std::vector<Vector3d> footholds(const Contact& contact, int point, const Vector3d& middle) const {
    const Poses start = posed(
        problem_.bones, Trajectory(problem_.start.begin() + contact.first, problem_.start.begin() + contact.last + 1));
    std::vector<int64_t> known;
    for (int64_t t = contact.first; t <= contact.last; ++t)
      if (kept(t)) known.push_back(t);
    const auto at = [&](int64_t t) {
      return place_of(problem_.points[static_cast<size_t>(point)], start[static_cast<size_t>(t - contact.first)]);
    };
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

  /// Metres that the ball of a foot of generated motion has risen by in a frame of a contact: people roll over their
  /// toes before a foot goes, networks let it slide. None where it does not go, or a frame is kept.
  double toe_off(const Contact& contact, const Foot& foot, int64_t frame) const {
    if (!is_ball(foot.joint) || belief_.glide == 0 || kept(frame)) return 0;
    const auto steps = [&](int64_t frames) { return static_cast<double>(frames) / (clip_.rate * kToeOffStep); };
    const double before = steps(contact.last - frame);
    const auto step = static_cast<size_t>(before);
    const auto next = static_cast<size_t>(contact.last) + 1;
    if (step + 1 >= kToeOff.size() || next >= foot.track.size() || steps(contact.last - contact.first) < kLeastStand)
      return 0;
    if ((foot.track[next] - foot.track[next - 1]).norm() * clip_.rate <= kGoing) return 0;
    return kToeOff[step] + (before - static_cast<double>(step)) * (kToeOff[step + 1] - kToeOff[step]);
  }

  /// A contact holds its joint at one place, near to where it was found: the scene may push it aside as a whole.
  void add_footholds() {
    const double per_frame = 30 / clip_.rate;
    for (const Foot& foot : feet_) {
      const double still = is_ball(foot.joint) ? kContact : kHeelContact, near = nearness(still);
      for (const Contact& contact : foot.contacts) {
        const std::vector<Vector3d> places = footholds(contact, foot.joint, contact_place(contact, foot.track));
        for (int64_t t = contact.first; t <= contact.last; ++t) {
          Vector3d place = places[static_cast<size_t>(t - contact.first)],
                   weight = Vector3d::Constant(per_frame * weight_of(near));
          const double rise = toe_off(contact, foot, t);
          if (rise > 0) place.y() += rise, weight.y() = per_frame * weight_of(kHeelContact);
          problem_.places.push_back({t, foot.joint, place, weight, {}});
        }
        for (int64_t t = contact.first; near > still && t < contact.last; ++t) {
          Vector3d weight = Vector3d::Constant(per_frame * weight_of(still));
          if (toe_off(contact, foot, t + 1) > 0) weight.y() = 0;
          problem_.holds.push_back({t, foot.joint, weight});
        }
      }
    }
  }

  /// Balls of the feet not under the floor, and above it while they go: a foot does not drag.
  void add_clearance(const Poses& poses) {
    const double per_frame = 30 / clip_.rate;
    for (const Foot& foot : feet_) {
      if (!is_ball(foot.joint)) continue;
      std::vector<char> stands(poses.size(), 0);
      for (const Contact& contact : foot.contacts)
        std::fill(stands.begin() + contact.first, stands.begin() + contact.last + 1, 1);
      const Track track = track_of(poses, foot.joint);
      for (size_t t = 0; t < track.size(); ++t) {
        if (stands[t]) continue;
        const auto speed = [&](size_t from) {
          return from + 1 < track.size() ? (track[from + 1] - track[from]).norm() * clip_.rate : 0;
        };
        const double going =
            smooth_step((std::max(speed(t), t > 0 ? speed(t - 1) : 0) - kResting) / (kGoing - kResting));
        const double standing = foot.floor[t] + std::clamp(foot.standing - 0.01, 0.0, 0.02);
        const double height = standing + going * (std::max(standing, foot.floor[t] + kClear) - standing);
        if (track[t].y() < height + kReach)
          problem_.planes.push_back({static_cast<int64_t>(t), foot.joint, Vector3d::UnitY(), height,
                                     per_frame * weight_of(kClearPlace), false});
      }
    }
  }

  /// Long motions in windows that overlap: every second one first, side by side, then those between, which keep the
  /// outer halves of their overlaps as the others left them.
  Trajectory solve_windows(const SolveOptions& options) {
    Trajectory found = problem_.initial.empty() ? problem_.start : problem_.initial;
    const std::vector<std::array<int64_t, 2>> windows = windows_of(problem_.frames());
    const auto count = static_cast<int64_t>(windows.size());
    for (const int64_t parity : {0, 1})
      at::parallel_for(0, (count + 1 - parity) / 2, 1, [&](int64_t begin, int64_t end) {
        for (int64_t i = 2 * begin + parity; i < 2 * end + parity; i += 2) {
          solve_window(windows[static_cast<size_t>(i)], parity == 1, parity == 1 && i + 1 < count, options, found);
          one_solved(count);
        }
      });
    return found;
  }

  /// @param keeps_first,keeps_last whether the outer halves of its overlaps stay as they are
  void solve_window(const std::array<int64_t, 2>& window, bool keeps_first, bool keeps_last,
                    const SolveOptions& options, Trajectory& found) const {
    const auto [first, last] = window;
    int64_t begin = first + (keeps_first ? kOverlap / 2 : 0), end = last - (keeps_last ? kOverlap / 2 : 0);
    while (begin < end && kept(begin)) ++begin;
    while (begin < end && kept(end - 1)) --end;
    if (begin == end) return;
    // Of the frames that stay around it only those matter that terms tie to others.
    const int64_t tied = coupling(problem_), from = std::max(first, begin - tied), to = std::min(last, end + tied);
    Problem part = part_of(problem_, found, from, to);
    std::fill_n(part.fixed.begin(), begin - from, 1);
    std::fill_n(part.fixed.rbegin(), to - end, 1);
    const Trajectory solved = solve(part, options).trajectory;
    std::copy(solved.begin(), solved.end(), found.begin() + from);
  }

  void one_solved(int64_t windows) {
    if (!options_.progress) return;
    const std::lock_guard<std::mutex> lock(counting_);
    options_.progress(++solved_, windows * (rounds() + (smoothed_ ? 1 : 0)));
  }

  Clip clip_;
  const Options& options_;
  const Belief& belief_;
  const Surroundings& surroundings_;
  std::vector<BodyBall> balls_;
  std::optional<Flesh> flesh_;  // with Options::skin_depth
  Problem problem_;
  Levels levels_;
  bool smoothed_ = false;  // there is noise to be taken away
  std::mutex counting_;
  int64_t solved_ = 0;  // windows, over all rounds
  std::vector<Foot> feet_;
  std::vector<Rest> rests_;
};

}  // namespace

void add_kept(const std::string& what, const Clip& clip, Options& options) {
  const int64_t frames = clip.frames();
  std::stringstream parts(what);
  for (std::string part; std::getline(parts, part, ',');) {
    const int joint = standard_joint_called(part, clip.skeleton);
    const bool every = part.rfind("every:", 0) == 0;
    const std::string digits = every ? part.substr(6) : part;
    if (joint >= 0) {
      options.keep_joints.push_back(joint);
      continue;
    }
    if (digits.empty() || digits.size() > 9 ||
        !std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c); }))
      throw Error("keep",
                  "'" + part + "' is no frame, no every:N and no joint; there are " + joint_names_for(clip.skeleton));
    const int64_t number = std::stoll(digits);
    if (!every) {
      options.keep_frames.push_back(number);
      continue;
    }
    if (number < 1) throw Error("keep", "every:N wants 1 or more");
    for (int64_t t = 0; t < frames; t += number) options.keep_frames.push_back(t);
    if (frames > 0) options.keep_frames.push_back(frames - 1);
  }
}

Result refine(const Clip& clip, const Scene& scene, const Options& options) {
  if (!(options.foot_change > 0)) throw Error("foot_change", "is not over 0");
  if (!(options.smooth >= 0 && options.smooth <= 1e6)) throw Error("smooth", "is not from 0 to a million");
  if (!(options.keep_within > 0)) throw Error("keep_within", "is not over 0");
  if (options.feet.defined() && options.feet.sizes() != torch::IntArrayRef({clip.frames(), 4}))
    throw Error("feet", "are not four numbers for each frame");
  if (options.skin_depth && !(*options.skin_depth >= 0)) throw Error("skin_depth", "is under 0");
  for (const int64_t frame : options.keep_frames)
    if (frame < 0 || frame >= clip.frames())
      throw Error("keep", "there is no frame " + std::to_string(frame) + " in " + options.name + ", which has " +
                              std::to_string(clip.frames()));
  for (const GivenContact& contact : options.given)
    if (contact.joint < 0 || contact.joint >= kStandardJoints || contact.first < 0 || contact.last >= clip.frames() ||
        !contact.place.allFinite() || !contact.offset.allFinite())
      throw Error("given", "a contact is of no joint, frame or place");
  for (const int joint : options.keep_joints)
    if (joint < 0 || joint >= kStandardJoints) throw Error("keep", "there is no joint " + std::to_string(joint));
  const Clip standard = retarget(clip, options.name);
  const Surroundings surroundings(rooms_looking_in(scene, standard.root_path()));
  Result out = Refinement(standard, surroundings, options).run();
  if (!options.standard) {
    std::vector<int64_t> all(static_cast<size_t>(clip.frames()));
    std::iota(all.begin(), all.end(), 0);
    SourcePoses poses = poses_of(clip, out.before, all, all, all);
    poses.exact.assign(all.size(), false);
    for (const int64_t frame : options.keep_frames) poses.exact[static_cast<size_t>(frame)] = true;
    out.on_source = on_source_skeleton(out.clip, poses, clip.frames());
    if (!out.hands.empty()) out.on_source.hand_targets = out.clip.hand_targets;
  }
  return out;
}

Clip refine_continuation(const Clip& past, const Clip& future, const SharedSurroundings& surroundings) {
  const Clip before = slice(past, std::max<int64_t>(0, past.frames() - kBefore), past.frames());
  Clip whole = future;
  // Labels are of the future alone.
  whole.action = whole.contact = whole.hand_targets = whole.object_pose = torch::Tensor();
  whole.joints = torch::cat({before.joints, future.joints});
  whole.rotations = torch::cat({before.rotations, future.rotations});
  whole.trans = torch::cat({before.trans, future.trans});
  Options options;
  options.generated = true;
  options.foot_change = kSoftFoot;
  options.keep_frames.resize(static_cast<size_t>(before.frames()));
  std::iota(options.keep_frames.begin(), options.keep_frames.end(), 0);
  const Clip standard = retarget(whole, "the continuation");
  const Clip refined = Refinement(standard, surroundings.around(standard.root_path()), options).run().clip;
  return slice(refined, before.frames(), whole.frames());
}

}  // namespace inhabit::refine
