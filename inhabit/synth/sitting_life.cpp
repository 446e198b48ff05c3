#include "inhabit/synth/sitting_life.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/random.h"
#include "inhabit/synth/seated_legs.h"

namespace inhabit {

using Eigen::Vector3d;

bool SittingWriter::live_on(const Seat& seat, const SeatStay& times, const ChairTake& take, bool leaves) {
  const Interaction interaction = take.interaction;
  Stay stay{seat, times, {}, {}, interaction == Interaction::free, take.parts};
  std::array<bool, 2> first{};
  if (interaction == Interaction::free) {
    stay.may_touch = {true, true};
    const int which = uniform_int(random_, 0, 4);  // none twice, left, right, both
    first = {which == 2 || which == 4, which == 3 || which == 4};
  } else {
    const bool both = interaction == Interaction::both_hands;
    first = stay.may_touch = {both || interaction == Interaction::left_hand,
                              both || interaction == Interaction::right_hand};
  }
  legs_free_ = 0;
  does_at(times.down, Action::sit_down);
  does_at(times.seated, Action::sit);
  const bool until_rise = leaves && chance(random_, 0.2);
  std::vector<Contact> held;
  for (int side = 0; side < 2; ++side) {
    if (!first[static_cast<size_t>(side)]) continue;
    const auto contact = find_contact(stay, side);
    if (!contact) return false;
    held.push_back(*contact);
  }
  TrunkMove posture;
  if (!find_posture(stay, held, posture)) return false;
  if (!held.empty()) {
    const double rising = times.risen - times.rise;
    const double held_until = until_rise ? times.rise + uniform(random_, 0.3, 0.45) * rising
                                         : std::min(times.seated + uniform(random_, 0.6, 3.5), times.rise - 1.0);
    for (const Contact& contact : held)
      reach_while_sitting_down(stay, contact, posture, held.size() == 1, held_until - uniform(random_, 0, 0.15));
    posture.when = {times.down + 0.3 * (times.seated - times.down), times.down + 0.85 * (times.seated - times.down),
                    held_until, held_until + 0.9};
    life_->trunk.push_back(posture);
  }
  for (int side = 0; side < 2; ++side) rest_on_thigh(stay, side, until_rise && first[static_cast<size_t>(side)]);
  const bool pushes = leaves && !until_rise && !held.empty() && chance(random_, 0.45);
  pass_time(stay, times.seated + uniform(random_, 0.2, 0.8), times.rise - (pushes ? 0.95 : 0.4));
  if (pushes)
    for (const Contact& contact : held) push_off(stay, contact);
  life_->seats.push_back(times);
  life_->used.push_back(seat.furniture);
  does_at(times.rise, Action::stand_up);
  return true;
}

std::optional<SittingWriter::Contact> SittingWriter::find_contact(const Stay& stay, int side) {
  for (int attempt = 0; attempt < 6; ++attempt) {
    const double draw = uniform(random_, 0, 1);
    Contact contact;
    if (!stay.parts.empty())
      contact.part = stay.parts[static_cast<size_t>(draw * static_cast<double>(stay.parts.size()))];
    else if (stay.seat.arms.empty())
      contact.part = draw < 0.4 ? SeatPart::seat_side : draw < 0.75 ? SeatPart::seat_front : SeatPart::back_rest;
    else
      contact.part = draw < 0.75 ? SeatPart::arm_rest : draw < 0.9 ? SeatPart::seat_front : SeatPart::seat_side;
    const auto trip = touch_seat(contact.part, side, chair_, stay.seat, stay.times.root, figure_, random_);
    if (!trip) continue;
    contact.trip = *trip;
    return contact;
  }
  return std::nullopt;
}

bool SittingWriter::find_posture(const Stay& stay, const std::vector<Contact>& contacts, TrunkMove& posture) const {
  if (contacts.empty()) return true;
  const double mirror = contacts.size() != 1 ? 0 : contacts.front().trip.side == 0 ? 1 : -1;
  Controls c;
  c.root = stay.times.root;
  c.yaw = stay.seat.heading;
  for (FootControl& foot : c.foot) foot.ball = c.root;  // only the trunk and the arms count here
  for (const Contact& contact : contacts) {
    HandPull& pull = c.arm[static_cast<size_t>(contact.trip.side)].pull[0];
    pull = contact.trip.pull;
    pull.weight = 1;
  }
  const auto held = [&](const Contact& contact) {
    const HandPull& pull = contact.trip.pull;
    const auto wrist = 20 + static_cast<size_t>(contact.trip.side);
    const Posed pose = pose_figure(figure_, c);
    return (pose.position[wrist] - pull.place).norm() < 0.004 &&
           pose.global[wrist].angularDistance(pull.rotation) < 0.15;
  };
  double cheapest = 1e9;
  for (double bend = 0; bend < 0.75; bend += 0.06)
    for (double lean = 0; lean < (mirror == 0 ? 0.01 : 0.31); lean += 0.06) {
      if (bend + 1.5 * lean >= cheapest) continue;
      c.tilt = 0.5 * bend - 0.13;  // as one sits
      c.bend = 0.5 * bend + 0.12;
      c.lean = mirror * lean;
      if (!std::all_of(contacts.begin(), contacts.end(), held)) continue;
      cheapest = bend + 1.5 * lean;
      posture.tilt = posture.bend = 0.5 * bend;
      posture.lean = c.lean;
    }
  return cheapest < 1e9;
}

void SittingWriter::reach_while_sitting_down(Stay& stay, const Contact& contact, const TrunkMove& posture, bool alone,
                                             double held_until) {
  const SeatStay& times = stay.times;
  const double going = times.seated - times.down, rising = times.risen - times.rise;
  const bool arm = contact.part == SeatPart::arm_rest, back = contact.part == SeatPart::back_rest;
  const bool until_rise = held_until > times.rise;
  HandTrip trip = contact.trip;
  const double set_out = times.down - subject_.early * uniform(random_, 0.6, 1.4);
  const double there = times.down + going * (arm    ? uniform(random_, 0.6, 0.85)
                                             : back ? uniform(random_, 0.7, 0.88)
                                                    : uniform(random_, 0.76, 0.9));
  trip.when = {set_out, there, held_until, 0};
  trip.when.end = trip.when.fall + (until_rise ? 0.45 * rising : uniform(random_, 0.6, 0.9));
  trip.arch = 0.03;
  life_->hands.push_back(trip);
  stay.busy_until[static_cast<size_t>(trip.side)] = trip.when.end;

  const double mirror = trip.side == 0 ? 1 : -1;
  const double most = subject_.trunk * (alone ? 1 : 0.25) * (arm ? 0.6 : 1);
  TrunkMove prepare;
  prepare.when = {set_out - 0.15, there - 0.1 * going, there + 0.2, times.seated + uniform(random_, 0.6, 1.0)};
  prepare.twist = mirror * most * uniform(random_, 0.12, 0.28) * (back ? 1.3 : 1);
  prepare.lean = std::max(0.0, most * uniform(random_, 0.06, 0.15) - std::abs(posture.lean)) * mirror;
  life_->trunk.push_back(prepare);
  if (chance(random_, subject_.looks))
    life_->looks.push_back({{set_out - 0.3, set_out + 0.25, there - 0.35, there + 0.3}, trip.point});
}

void SittingWriter::rest_on_thigh(Stay& stay, int side, bool held_until_rise) {
  if (held_until_rise) return;
  const SeatStay& times = stay.times;
  const double going = times.seated - times.down, rising = times.risen - times.rise;
  const double busy = stay.busy_until[static_cast<size_t>(side)];
  HandTrip lap = thigh_hand(side, figure_, random_);
  // Between arm rests the hands go to the thighs before the arm rests are beside them.
  const double early = stay.seat.arms.empty() ? uniform(random_, 0.2, 0.5) : uniform(random_, 0.0, 0.15);
  lap.when.rise = busy > 0 ? busy - 0.85 : times.down + early * going;
  for (const HandTrip& trip : life_->hands)
    if (trip.side == side && trip.when.end == busy && busy > 0) lap.when.rise = trip.when.fall - 0.05;
  lap.when.full = lap.when.rise + (busy > 0 ? 0.8 : 0.65 * going);
  lap.when.fall = times.rise + (stay.seat.arms.empty() ? 0.3 : 0.55) * rising;
  lap.when.end = times.risen + 0.1;
  if (lap.when.fall > lap.when.full) life_->hands.push_back(lap);
}

void SittingWriter::push_off(const Stay& stay, const Contact& contact) {
  const double rise = stay.times.rise, rising = stay.times.risen - rise;
  HandTrip trip = contact.trip;
  trip.when = {rise - 0.8, rise - 0.05, rise + uniform(random_, 0.3, 0.45) * rising, rise + 0.95 * rising};
  life_->hands.push_back(trip);
}

void SittingWriter::pass_time(Stay& stay, double from, double until) {
  double t = from;
  while (until - t > 1.3) {
    const double length = std::min(until - t, uniform(random_, 1.4, stay.lively ? 3.0 : 3.6));
    const double ease = std::min(0.8, 0.4 * length);
    const double hands_free = std::max(stay.busy_until[0], stay.busy_until[1]);
    const bool free_hands = t > hands_free - 0.1;
    TrunkMove move;
    move.when = {t, t + ease, t + length - ease, t + length};
    const double draw = uniform(random_, 0, 1);
    double done = length;
    if (draw < 0.18 && free_hands) {
      gesture(t, t + length, true);
      move.bend = uniform(random_, 0.0, 0.1);
      move.twist = uniform(random_, -0.15, 0.15);
    } else if (draw < 0.36 && free_hands && stay.seat.back) {
      lean_back(stay.seat, stay.times, move);
      does_at(t, Action::lean_back);
      does_at(t + length, Action::sit);
    } else if (draw < (stay.lively ? 0.5 : 0.42) && free_hands && until - t > 2.4) {
      done = std::min(until - t, uniform(random_, 2.4, 4.0));
      move.when = {t, t + 0.8, t + done - 0.8, t + done};
      hands_behind_head(t, t + done, move);
      does_at(t, Action::gesture);
      does_at(t + done, Action::sit);
    } else if (draw < (stay.lively ? 0.66 : 0.54)) {
      done = move_legs(stay, t, until, move);
      if (done == 0) {
        done = 0.2;
        move.when.end = 0;
      }
    } else if (draw < (stay.lively ? 0.82 : 0.62)) {
      done = touch_again(stay, t, until);
      if (done == 0) done = 0.3;
      move.when.end = 0;
    } else if (draw < (stay.lively ? 0.9 : 0.74)) {
      shift(stay, move);
    } else if (draw < (stay.lively ? 0.93 : 0.9) && free_hands) {
      move.tilt = uniform(random_, 0.05, 0.22);
      move.bend = uniform(random_, 0.05, 0.22);
    } else {
      move.lean = uniform(random_, -0.08, 0.08);
      move.twist = uniform(random_, -0.25, 0.25);
      move.shift = Vector3d(uniform(random_, -0.015, 0.015), 0, uniform(random_, -0.015, 0.015));
      look_about(t, t + length);
    }
    if (move.when.end > 0) life_->trunk.push_back(move);
    t += done + uniform(random_, 0.05, 0.5);
  }
}

/// A hand goes to the chair once more. @return seconds that it takes, 0 where no hand can.
double SittingWriter::touch_again(Stay& stay, double t, double until) {
  const int side = uniform_int(random_, 0, 1);
  const auto s = static_cast<size_t>(side);
  if (!stay.may_touch[s] || stay.busy_until[s] > t || until - t < 2.2) return 0;
  const auto contact = find_contact(stay, side);
  TrunkMove move;
  if (!contact || !find_posture(stay, {*contact}, move)) return 0;
  HandTrip trip = contact->trip;
  const double reach = life_->manner.pace * uniform(random_, 0.6, 0.95), back = uniform(random_, 0.6, 0.9);
  const double hold = std::min(uniform(random_, 0.5, 2.5), until - t - reach - back);
  trip.when = {t, t + reach, t + reach + hold, t + reach + hold + back};
  life_->hands.push_back(trip);
  stay.busy_until[s] = trip.when.end;
  const double mirror = side == 0 ? 1 : -1;
  move.when = {t - 0.1, t + reach, trip.when.fall, trip.when.end};
  move.lean += mirror * uniform(random_, 0.0, 0.06) * subject_.trunk;
  move.twist = mirror * uniform(random_, 0.0, 0.12) * subject_.trunk;
  life_->trunk.push_back(move);
  if (chance(random_, subject_.looks))
    life_->looks.push_back({{t - 0.25, t + 0.2, t + reach - 0.2, t + reach + 0.4}, trip.point});
  return trip.when.end - t;
}

/// The legs are stretched, or crossed at the ankles or the knees. @return seconds that it takes, 0 where the time is
/// too short
double SittingWriter::move_legs(Stay& stay, double t, double until, TrunkMove& move) {
  const double rest = std::max(legs_free_, t);
  if (until - rest < 3.0 || rest - t > 0.5) return 0;
  const double length = std::min(until - rest, uniform(random_, 3.0, stay.lively ? 5.5 : 4.5));
  const SeatedLegs legs{figure_, stay.times, life_->steps.heading(), rest, rest + length};
  const bool free_hands = std::max(stay.busy_until[0], stay.busy_until[1]) < t - 0.1;
  const double draw = uniform(random_, 0, 1);
  std::vector<LegMove> moves;
  if (draw < 0.38) {
    moves = legs.stretched(uniform_int(random_, 0, 2), random_);
  } else if (draw < 0.72 || !free_hands) {
    moves = legs.ankles_crossed(uniform_int(random_, 0, 1), random_);
  } else {
    moves = legs.legs_crossed(uniform_int(random_, 0, 1), random_);
    hand_on_crossed_leg(stay, moves.front());
  }
  life_->legs.insert(life_->legs.end(), moves.begin(), moves.end());
  legs_free_ = rest + length;
  // Who lifts a leg leans away from it a little, against the back rest where there is one.
  move.when = {rest, rest + 0.9, rest + length - 0.9, rest + length};
  if (stay.seat.back && chance(random_, 0.6) && stay.busy_until[0] < t && stay.busy_until[1] < t)
    lean_back(stay.seat, stay.times, move);
  else
    move.tilt = uniform(random_, -0.08, -0.02);
  return rest - t + length;
}

/// The hand that lay on the lower thigh goes to the knee that comes over it.
void SittingWriter::hand_on_crossed_leg(Stay& stay, const LegMove& move) {
  const int side = 1 - move.side;
  const double mirror = side == 0 ? 1 : -1, go = move.when.full - move.when.rise;
  HandTrip trip = thigh_hand(side, figure_, random_);
  trip.pull.anchor = 1 + move.side;
  trip.pull.place = figure_.bones.offsets[4 + move.side] * uniform(random_, 0.78, 0.9) +
                    Vector3d(mirror * 0.03, 0, figure_.thigh_depth + figure_.palm_depth);
  const Vector3d ahead = Vector3d(-mirror, -uniform(random_, 0.3, 0.6), -0.1).normalized();
  trip.pull.rotation = hand_rotation(side, ahead, -Vector3d::UnitZ());
  trip.arch = 0.08;
  // Away before the leg comes, and back after it has gone.
  trip.when = {move.when.rise - 0.35, move.when.rise + 0.5 * go, move.when.fall + 0.4 * go, move.when.end + 0.3};
  life_->hands.push_back(trip);
  stay.busy_until[static_cast<size_t>(side)] = trip.when.end;
}

/// The weight goes to one side, the pelvis comes up a little and sits down beside where it was, for a while.
void SittingWriter::shift(const Stay& stay, TrunkMove& move) {
  const double side = chance(random_, 0.5) ? 1 : -1;
  const Vector3d ahead = stay.seat.pose.linear().col(2), left = stay.seat.pose.linear().col(0);
  move.shift = ahead * uniform(random_, 0.0, 0.045) + left * side * uniform(random_, 0.01, 0.03);
  move.lean = side * uniform(random_, 0.03, 0.09);
  move.twist = -side * uniform(random_, 0.0, 0.12);
  TrunkMove effort;
  effort.when = {move.when.rise - 0.1, move.when.rise + 0.35, move.when.rise + 0.4, move.when.full + 0.35};
  effort.tilt = uniform(random_, 0.05, 0.14);
  effort.lean = side * uniform(random_, 0.06, 0.14);
  effort.shift = Vector3d(0, uniform(random_, 0.006, 0.014), 0);
  life_->trunk.push_back(effort);
}

void SittingWriter::hands_behind_head(double from, double until, TrunkMove& move) {
  move.bend = uniform(random_, -0.12, -0.02);
  for (int side = 0; side < 2; ++side) {
    const double mirror = side == 0 ? 1 : -1;
    HandTrip trip;
    trip.side = side;
    const double go = uniform(random_, 0.75, 0.95);
    trip.when = {from, from + go, until - uniform(random_, 0.7, 0.85), until};
    trip.pull.anchor = 15;
    trip.pull.place = {mirror * 0.12, 0.1, -0.1};  // fingers meet behind the head, within the forearm's limits
    trip.pull.rotation = hand_rotation(side, Vector3d(-mirror, 0.6, 0).normalized(), Vector3d(0, 0, 1));
    trip.pull.swivel = uniform(random_, 1.4, 1.9);
    life_->hands.push_back(trip);
  }
}

}  // namespace inhabit
