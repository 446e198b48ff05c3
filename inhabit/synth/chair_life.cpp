#include "inhabit/synth/chair_life.h"

#include <algorithm>
#include <cmath>

#include "inhabit/body/capsules.h"
#include "inhabit/math/random.h"
#include "inhabit/synth/chair_plan.h"
#include "inhabit/synth/collide.h"
#include "inhabit/synth/life_writer.h"
#include "inhabit/synth/person.h"
#include "inhabit/synth/seated_legs.h"

namespace inhabit {
namespace {

constexpr int kDraws = 40;
constexpr double kLegOnLeg = 0.04;  // metres of the capsules, which are thicker than a leg in between

/// Metres that capsules of a joint may be in the chair that is used.
double allowed_depth(int joint) {
  switch (joint) {
    case 0:
    case 1:
    case 2:
      return 0.085;  // flesh on the seat
    case 3:
    case 6:
    case 9:
      return 0.03;  // the back on the back rest
    case 20:
    case 21:
      return 0.055;  // the capsule of a hand is thicker than a hand that lies flat
    default:
      return 0.025;
  }
}

/// Metres beyond what is allowed that the body is in the chair, at most.
double too_deep_in_chair(const Furniture& chair, const std::vector<Capsule>& capsules, const Performance& performance) {
  double worst = 0;
  for (const Capsule& capsule : capsules)
    worst = std::max(worst, deepest_in(chair, {capsule}, performance) - allowed_depth(capsule.joint));
  return worst;
}

/// Metres that a leg that is moved is in the other one, at most.
double legs_through_each_other(const Life& life, const std::vector<Capsule>& capsules, const Performance& performance) {
  double worst = 0;
  for (size_t t = 0; t < performance.pose.size(); ++t) {
    const double second = life.from + static_cast<double>(t) / kSynthRate;
    if (std::any_of(life.plan.legs.begin(), life.plan.legs.end(),
                    [&](const LegMove& move) { return move.when.at(second) > 0; }))
      worst = std::max(worst, legs_in_each_other(capsules, performance.pose[t]));
  }
  return worst;
}

/// The first frame in which the pelvis is on the seat, or the number of frames.
int first_seated(const Performance& performance) {
  size_t t = 0;
  while (t < performance.contact.size() && !performance.contact[t][0]) ++t;
  return static_cast<int>(t);
}

/// The number of planned contacts that a hand does not come to hold when the pelvis does at the latest, or, later,
/// within a quarter of a second, or that it loses before their time.
int missed_contacts(const Life& life, const Performance& performance) {
  int missed = 0;
  const auto frames = static_cast<int>(performance.pose.size());
  const auto frame_at = [&](double t) { return static_cast<int>(std::ceil((t - life.from) * kSynthRate)); };
  const int seated = first_seated(performance);
  for (const HandTrip& trip : life.plan.hands) {
    if (!trip.touches) continue;
    const int there = frame_at(trip.when.full), first = there <= seated ? seated : there + 8;
    const int last = std::min(frame_at(trip.when.fall - 0.08), frames);
    bool held = there < frames ? last - first >= 6 || last == frames : true;
    for (int t = std::max(0, first); held && t < last; ++t) {
      const Eigen::Vector4d& target = performance.hand_target[static_cast<size_t>(t)][static_cast<size_t>(trip.side)];
      held = target[3] != 0 && (target.head<3>() - trip.point).norm() < 1e-9;
    }
    if (!held) ++missed;
  }
  return missed;
}

}  // namespace

const std::vector<std::string>& interaction_names() {
  static const std::vector<std::string> names = {"right_hand", "left_hand", "both_hands",
                                                 "no_contact", "free",      "locomotion"};
  return names;
}

const std::vector<std::string>& seat_part_names() {
  static const std::vector<std::string> names = {"armrest", "front", "side", "back"};
  return names;
}

ChairSubject draw_subject(const BodyModel& body, std::mt19937_64& random) {
  ChairSubject subject;
  subject.betas = draw_betas(body, random);
  subject.figure = std::make_shared<const Figure>(make_figure(body, subject.betas));
  subject.gait = draw_gait(random);
  subject.manner = draw_manner(random);
  subject.early = uniform(random, 0.2, 0.6);
  subject.trunk = uniform(random, 0.6, 1.4);
  subject.looks = uniform(random, 0.25, 0.9);
  subject.walks_off = uniform(random, 0.35, 0.75);
  return subject;
}

std::optional<Clip> sit_on_chair(const Room& room, const FreeSpace& floor, const BodyModel& body,
                                 const ChairSubject& subject, const ChairTake& take, std::mt19937_64& random) {
  const torch::NoGradGuard no_gradient;
  const auto frames = static_cast<int>(std::lround(take.seconds * kSynthRate));
  const std::vector<Capsule> capsules = shaped_capsules(body, subject.betas);
  for (int attempt = 0; attempt < kDraws; ++attempt) {
    auto plan = plan_chair_life(room, floor, subject, take, random);
    if (!plan) continue;
    Life life{subject.betas, subject.figure, std::move(*plan), 0, std::mt19937_64(random())};
    const Performance performance = life.performed(0, frames);
    if (missed_contacts(life, performance) > 0 || faults_of(room, body, life, performance) > 0 ||
        too_deep_in_chair(room.furniture[0], capsules, performance) > 0 ||
        legs_through_each_other(life, capsules, performance) > kLegOnLeg)
      continue;
    return clip_of(room, body, subject.betas, performance, {0});
  }
  return std::nullopt;
}

}  // namespace inhabit
