#include "inhabit/synth/life_plan.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/random.h"
#include "inhabit/synth/life_writer.h"
#include "inhabit/synth/seat.h"
#include "inhabit/synth/touch.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class Planner : private LifeWriter {
 public:
  Planner(const Room& room, const FreeSpace& floor, const Figure& figure, std::mt19937_64& random)
      : LifeWriter(floor, figure, random),
        region_(walkable_regions(floor, 0.26)),
        seats_(seats_of(room, figure)),
        touches_(touch_places(room)) {}

  LifePlan plan(double seconds) {
    const GaitStyle gait = draw_gait(random_);
    const Manner manner = draw_manner(random_);

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

  bool go_somewhere() {
    if (!go(free_place(), 2.2)) return false;
    stand_about(chance(random_, 0.3) ? uniform(random_, 1.5, 3.5) : uniform(random_, 0.2, 0.7));
    return true;
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

  std::vector<int32_t> region_;
  std::vector<Seat> seats_;
  std::vector<TouchPlace> touches_;
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
