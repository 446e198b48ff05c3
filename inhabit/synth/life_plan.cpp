#include "inhabit/synth/life_plan.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/random.h"
#include "inhabit/synth/seat.h"
#include "inhabit/synth/touch.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class Planner {
 public:
  Planner(const Room& room, const FreeSpace& floor, const Figure& figure, std::mt19937_64& random)
      : floor_(floor),
        figure_(figure),
        random_(random),
        region_(walkable_regions(floor, 0.26)),
        seats_(seats_of(room, figure)),
        touches_(touch_places(room)) {}

  LifePlan plan(double seconds) {
    GaitStyle gait;
    gait.speed = std::clamp(normal(random_, 1.32, 0.11), 1.1, 1.55);
    gait.walk_ratio = 0.0061 * std::clamp(normal(random_, 1, 0.06), 0.88, 1.12);
    gait.width = std::clamp(normal(random_, 0.09, 0.025), 0.04, 0.15);
    gait.toe_out = uniform(random_, 0.03, 0.16);
    gait.clearance = uniform(random_, 0.038, 0.055);
    gait.double_support = uniform(random_, 0.22, 0.27);
    gait.push_off = uniform(random_, 0.92, 1.08);
    Manner manner;
    manner.arm_swing = uniform(random_, 0.38, 0.8);
    manner.arms_out = uniform(random_, 0.12, 0.22);
    manner.elbow = uniform(random_, 0.14, 0.32);
    manner.upright = uniform(random_, -0.01, 0.05);
    manner.sway = uniform(random_, 0.7, 1.3);
    manner.pace = uniform(random_, 0.85, 1.2);

    const bool seated = !seats_.empty() && chance(random_, 0.25);
    const Seat* first = nullptr;
    Vector2d place;
    double heading = uniform(random_, -M_PI, M_PI);
    if (seated) {
      first = &seats_[random_() % seats_.size()];
      heading = first->heading;
      place = stand_place(*first, figure_, random_);
    } else {
      place = free_place();
    }
    LifePlan life(figure_, gait, place, heading);
    life_ = &life;
    life.manner = manner;
    life.favour.add(-1e3, 0);
    if (seated)
      stay_on(*first, true);
    else
      stand_about(uniform(random_, 0.4, 1.6));
    go_on(life, seconds);
    return life;
  }

  /// Adds to a life until it lasts `seconds`.
  void go_on(LifePlan& life, double seconds) {
    life_ = &life;
    int failures = 0;
    while (life.steps.now() < seconds + 1.5) {
      const double draw = uniform(random_, 0, 1);
      bool done = false;
      if (draw < 0.5 && !seats_.empty())
        done = go_and_sit(seats_[random_() % seats_.size()]);
      else if (draw < 0.78 && !touches_.empty())
        done = go_and_touch(touches_[random_() % touches_.size()]);
      else
        done = go_somewhere();
      if (!done && ++failures > 12) {
        stand_about(uniform(random_, 1.5, 3));
        failures = 8;
      }
    }
    life_ = nullptr;
  }

 private:
  double now() const { return life_->steps.now(); }
  void does(Action action) { life_->doing.push_back({now(), action}); }
  void does_at(double t, Action action) { life_->doing.push_back({t, action}); }

  /// A place on the main part of the floor, with elbow room if there is any.
  Vector2d free_place() {
    Vector2d best(0, 0);
    double widest = -1;
    for (int k = 0; k < 60; ++k) {
      const size_t i = random_() % region_.size();
      if (region_[i] != 1) continue;
      const Vector2d p = floor_.point(static_cast<int>(i) % floor_.nx, static_cast<int>(i) / floor_.nx);
      if (floor_.clearance[i] > widest) best = p, widest = floor_.clearance[i];
      if (widest > 0.45) break;
    }
    return best;
  }

  /// Stands for `seconds`, shifting weight and looking about.
  void stand_about(double seconds) {
    does(Action::stand);
    const double from = now(), until = from + seconds;
    double t = from + 0.3;
    while (t + 0.9 < until) {
      const double hold = uniform(random_, 0.8, 2.2);
      const double side = chance(random_, 0.5) ? 1 : -1;
      life_->favour.add(t, 0);
      life_->favour.add(t + 0.7, side * uniform(random_, 0.25, 0.6));
      const double back = std::min(t + 0.7 + hold, until - 0.1);
      life_->favour.add(back, side * uniform(random_, 0.25, 0.6));
      life_->favour.add(back + 0.7, 0);
      if (chance(random_, 0.5)) look_about(t, std::min(t + 1.6, until));
      if (chance(random_, 0.3)) gesture(t, std::min(until, t + uniform(random_, 1.2, 2.4)), false);
      t = back + 0.8;
    }
    life_->steps.wait(seconds);
  }

  void look_about(double from, double until) {
    if (until - from < 0.8) return;
    const Vector2d ahead = ahead_of(life_->steps.heading() + uniform(random_, -1.0, 1.0)) * 2;
    const Vector2d p = life_->steps.place() + ahead;
    life_->looks.push_back(
        {{from, from + 0.45, until - 0.4, until + 0.1}, Vector3d(p.x(), uniform(random_, 0.7, 1.7), p.y())});
  }

  /// Hands speak: one or both move in front of the chest.
  void gesture(double from, double until, bool seated) {
    const int both = uniform_int(random_, 0, 2);
    double t = from;
    bool any = false;
    while (t + 0.9 < until) {
      const double go = uniform(random_, 0.45, 0.7), hold = uniform(random_, 0.1, 0.5),
                   back = uniform(random_, 0.45, 0.75);
      for (int side = 0; side < 2; ++side) {
        if (both != 2 && both != side) continue;
        const double mirror = side == 0 ? 1 : -1;
        HandTrip trip;
        trip.side = side;
        trip.when = {t + uniform(random_, 0, 0.1), t + go + 0.1, t + go + 0.1 + hold, t + go + 0.1 + hold + back};
        trip.pull.anchor = 9;
        // From the upper chest's joint: beside, below and in front.
        trip.pull.place = {mirror * uniform(random_, 0.06, 0.26), uniform(random_, seated ? -0.12 : -0.18, 0.06),
                           uniform(random_, 0.24, 0.36)};
        const Vector3d ahead =
            Vector3d(-mirror * uniform(random_, 0.1, 0.7), uniform(random_, -0.1, 0.6), 1).normalized();
        const Vector3d palm = Vector3d(-mirror, uniform(random_, -0.8, 0.8), 0.1).normalized();
        trip.pull.turn = hand_turn(side, ahead, palm);
        trip.pull.swivel = uniform(random_, 0.25, 0.6);
        life_->hands.push_back(trip);
        any = true;
      }
      t += go + hold + uniform(random_, 0.2, 0.45);
    }
    if (!any) return;
    does_at(from, Action::gesture);
    does_at(until, seated ? Action::sit : Action::stand);
  }

  /// To `place` and facing `heading` if given; false when there is no path.
  bool go(const Vector2d& place, double least) {
    const Vector2d here = life_->steps.place();
    if ((place - here).norm() < least) return false;
    auto path = find_path(floor_, here, place, 0.32);
    if (!path) path = find_path(floor_, here, place, 0.27);  // through a gap
    if (!path || path->total() > 9) return false;
    const double first = path->heading(std::min(0.3, path->total()));
    const double off = wrapped(first - life_->steps.heading());
    if (std::abs(off) > 0.9) {
      does(Action::turn);
      life_->steps.turn(life_->steps.heading() + (std::abs(off) - 0.25) * (off > 0 ? 1 : -1), here, random_);
    }
    does_at(now() + 0.28, Action::walk);
    const double speed = life_->gait.speed * uniform(random_, 0.92, 1.08) * std::min(1.0, 0.82 + 0.07 * path->total());
    does_at(life_->steps.walk(*path, speed, random_), Action::stand);
    return true;
  }

  bool go_somewhere() {
    if (!go(free_place(), 2.2)) return false;
    stand_about(chance(random_, 0.3) ? uniform(random_, 1.5, 3.5) : uniform(random_, 0.2, 0.7));
    return true;
  }

  void turn_to(double heading, const Vector2d& place) {
    const double off = std::abs(wrapped(heading - life_->steps.heading()));
    if (off < 0.08 && (place - life_->steps.place()).norm() < 0.02) return;
    does(Action::turn);
    life_->steps.turn(heading, place, random_);
    does(Action::stand);
  }

  bool go_and_sit(const Seat& seat) {
    const Vector2d stand = stand_place(seat, figure_, random_);
    const Vector2d before = stand + ahead_of(seat.heading) * uniform(random_, 0.22, 0.32);
    if (floor_.at(before) < 0.17) return false;
    if ((before - life_->steps.place()).norm() > 0.4 && !go(before, 1.6)) return false;
    turn_to(seat.heading, stand);
    life_->steps.wait(uniform(random_, 0.15, 0.4));
    stay_on(seat, false);
    return true;
  }

  /// Sits down (unless already seated when the clip begins), lives on the seat and stands up.
  void stay_on(const Seat& seat, bool already) {
    const double stand_at = now();
    SeatStay stay = plan_stay(seat, figure_, life_->steps.place(), random_);
    const double pace = life_->manner.pace;
    stay.down = already ? -20 : stand_at;
    stay.seated = stay.down + pace * uniform(random_, 1.45, 1.9);
    const double from = already ? 0 : stay.seated;
    const double life = uniform(random_, 2.2, 6.5);
    stay.rise = from + life;
    stay.risen = stay.rise + pace * uniform(random_, 1.3, 1.75);
    if (!already) does(Action::sit_down);
    does_at(from, Action::sit);
    plan_seat_hands(seat, stay, figure_, random_, life_->hands);
    sit_about(seat, stay, from + 0.3, stay.rise - 0.35);
    life_->seats.push_back(stay);
    life_->used.push_back(seat.furniture);
    does_at(stay.rise, Action::stand_up);
    life_->steps.wait(stay.risen + 0.15 - now());
    does(Action::stand);
    if (chance(random_, 0.4)) stand_about(uniform(random_, 0.3, 1.0));
  }

  void sit_about(const Seat& seat, const SeatStay& stay, double from, double until) {
    double t = from;
    while (until - t > 1.2) {
      const double length = std::min(until - t, uniform(random_, 1.4, 3.2));
      const int what = uniform_int(random_, 0, 5);
      const double ease = std::min(0.8, 0.4 * length);
      TrunkMove move;
      move.when = {t, t + ease, t + length - ease, t + length};
      if (what <= 1) {
        gesture(t, t + length, true);
        move.bend = uniform(random_, 0.0, 0.1);
        move.twist = uniform(random_, -0.15, 0.15);
      } else if (what == 2 && seat.back) {
        lean_back(seat, stay, move);
        does_at(t, Action::lean_back);
        does_at(t + length, Action::sit);
      } else if (what == 3) {
        move.tilt = uniform(random_, 0.05, 0.25);
        move.bend = uniform(random_, 0.05, 0.25);
      } else {
        move.lean = uniform(random_, -0.1, 0.1);
        move.twist = uniform(random_, -0.3, 0.3);
        look_about(t, t + length);
      }
      life_->trunk.push_back(move);
      t += length + uniform(random_, 0.1, 0.6);
    }
  }

  /// Slides the pelvis to the back rest and leans on it.
  void lean_back(const Seat& seat, const SeatStay& stay, TrunkMove& move) {
    const Vector3d front = seat.pose * Vector3d(0, 0, 1) - seat.pose.translation();
    const double gap = (seat.pose.inverse() * stay.root).z() - seat.back_z - figure_.back_depth;
    const double slide = std::clamp(gap - 0.03, 0.0, 0.06);
    move.shift = -front * slide;
    move.tilt = -std::clamp(std::asin(std::clamp((gap - slide) / 0.4, 0.0, 0.4)), 0.0, 0.3);
    move.bend = uniform(random_, -0.06, 0.0);
    move.leans_on_back = gap - slide < 0.14;
  }

  bool go_and_touch(const TouchPlace& spot) {
    const auto touch = plan_touch(spot, floor_, figure_, random_);
    if (!touch) return false;
    if ((touch->stand - life_->steps.place()).norm() > 0.35 && !go(touch->stand, 1.5)) return false;
    turn_to(touch->heading, touch->stand);
    does(Action::reach);
    const double pace = life_->manner.pace, t = now() + 0.05;
    const double reach = pace * uniform(random_, 0.75, 1.15), hold = uniform(random_, 0.5, 2.0),
                 back = pace * uniform(random_, 0.8, 1.1);
    const Envelope when{t, t + reach, t + reach + hold, t + reach + hold + back};
    for (HandTrip trip : touch->hands) {
      // Through a place before the edge, a little higher.
      const double late = uniform(random_, 0, 0.1);
      HandTrip before = trip;
      before.touches = false;
      before.pull.place += touch->before_edge;
      before.when = {when.rise + late, when.rise + late + 0.7 * reach, when.fall + 0.3 * back, when.end};
      trip.when = {when.rise + late + 0.4 * reach, when.full + late, when.fall, when.fall + 0.62 * back};
      life_->hands.push_back(before);
      life_->hands.push_back(trip);
    }
    TrunkMove move = touch->trunk;
    move.when = {t - 0.05, t + reach, when.fall + 0.05, when.end + 0.1};
    life_->trunk.push_back(move);
    life_->looks.push_back({{t - 0.25, t + 0.2, when.fall - 0.1, when.fall + 0.5}, touch->hands.front().point});
    does_at(when.full, Action::touch);
    does_at(when.fall, Action::reach);
    does_at(when.end, Action::stand);
    life_->used.push_back(spot.furniture);
    life_->steps.wait(when.end + 0.1 - now());
    return true;
  }

  const FreeSpace& floor_;
  const Figure& figure_;
  std::mt19937_64& random_;
  std::vector<int32_t> region_;
  std::vector<Seat> seats_;
  std::vector<TouchPlace> touches_;
  LifePlan* life_ = nullptr;
};

}  // namespace

const std::vector<std::string>& action_names() {
  static const std::vector<std::string> names = {"stand",    "walk",  "turn",  "sit_down", "sit",
                                                 "stand_up", "reach", "touch", "gesture",  "lean_back"};
  return names;
}

LifePlan plan_life(const Room& room, const FreeSpace& floor, const Figure& figure, double seconds,
                   std::mt19937_64& random) {
  return Planner(room, floor, figure, random).plan(seconds);
}

void extend_life(LifePlan& life, const Room& room, const FreeSpace& floor, const Figure& figure, double seconds,
                 std::mt19937_64& random) {
  Planner(room, floor, figure, random).go_on(life, seconds);
}

}  // namespace inhabit
