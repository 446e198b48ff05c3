#include "inhabit/synth/chair_plan.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"
#include "inhabit/synth/life_writer.h"
#include "inhabit/synth/seat_touch.h"
#include "inhabit/synth/sitting_life.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMargin = 0.42;  // metres between the path and furniture: elbow room

class ChairPlanner : private SittingWriter {
 public:
  ChairPlanner(const Room& room, const FreeSpace& floor, const ChairSubject& subject, const ChairTake& take,
               std::mt19937_64& random)
      : SittingWriter(room.furniture[0], floor, subject, random), room_(room), take_(take) {}

  std::optional<LifePlan> plan() {
    std::vector<Seat> seats = seats_of(room_, figure_, 1);
    std::erase_if(seats, [](const Seat& seat) { return seat.furniture != 0; });
    const auto start = start_place();
    if (seats.empty() || !start) return std::nullopt;
    LifePlan life(figure_, subject_.gait, *start, uniform(random_, -M_PI, M_PI));
    life_ = &life;
    life.manner = subject_.manner;
    life.favour.add(-1e3, 0);
    stand_about(uniform(random_, 0.2, 1.0) + take_.before);
    const bool done = take_.interaction == Interaction::locomotion ? walk_about() : go_and_sit(seats);
    if (done && now() < take_.seconds + 0.5) stand_about(take_.seconds + 0.5 - now());
    life_ = nullptr;
    return done ? std::optional<LifePlan>(std::move(life)) : std::nullopt;
  }

 private:
  Vector2d chair_place() const { return on_ground(room_.furniture[0].pose.translation()); }
  double chair_heading() const { return heading_of(on_ground(room_.furniture[0].pose.linear().col(2))); }

  /// `distance` from the chair or a little farther, in `direction` (radians from the chair's front to its left).
  std::optional<Vector2d> place_around(double direction, double distance) const {
    for (double d = distance; d < distance + 1; d += 0.1) {
      const Vector2d p = chair_place() + ahead_of(chair_heading() + direction) * d;
      if (walkable(floor_, p, kMargin)) return p;
    }
    return std::nullopt;
  }
  std::optional<Vector2d> start_place() {
    return place_around(take_.direction + uniform(random_, -0.12, 0.12), take_.distance * uniform(random_, 0.97, 1.03));
  }

  /// From place to place around the chair.
  bool walk_about() {
    int failures = 0;
    while (now() < take_.seconds + 0.5 - take_.after) {
      const auto place = place_around(uniform(random_, -M_PI, M_PI), uniform(random_, 0.8, 3.5));
      if (!place || !go(*place, 1.5, kMargin)) {
        if (++failures > 20) return false;
        continue;
      }
      stand_about(chance(random_, 0.3) ? uniform(random_, 0.8, 2.0) : uniform(random_, 0.1, 0.5));
    }
    return true;
  }

  bool go_and_sit(const std::vector<Seat>& seats) {
    const Seat& seat = seats[random_() % seats.size()];
    const Vector2d stand = stand_place(seat, figure_, random_, seat.half_width);  // anywhere on wide seats
    const Vector2d before = stand + ahead_of(seat.heading) * (seat.arms.empty() ? uniform(random_, 0.18, 0.32)
                                                                                : uniform(random_, 0.34, 0.46));
    if (floor_.at(before) < 0.17) return false;
    const double far = (before - life_->steps.place()).norm();
    if (far > 0.6 && !go(before, 0.6, kMargin)) return false;
    turn_to(seat.heading, stand);
    life_->steps.wait(uniform(random_, 0.1, 0.45));
    SeatStay stay = plan_stay(seat, figure_, life_->steps.place(), random_);
    const double pace = life_->manner.pace;
    stay.down = now();
    stay.seated = stay.down + pace * uniform(random_, 1.4, 1.9);
    const double last = take_.seconds - take_.after, seconds_left = last - stay.seated;
    if (seconds_left < 3) return false;
    const bool leaves = seconds_left > 6.5 && (take_.after > 0 || chance(random_, subject_.walks_off));
    stay.rise = leaves ? last - uniform(random_, 3.0, std::min(5.0, seconds_left - 3.2)) : take_.seconds + 2;
    stay.risen = stay.rise + pace * uniform(random_, 1.3, 1.75);
    if (!live_on(seat, stay, take_, leaves)) return false;
    life_->steps.wait(std::max(0.0, stay.risen + 0.15 - now()));
    does(Action::stand);
    if (leaves) leave();
    return true;
  }

  void leave() {
    for (int attempt = 0; attempt < 8; ++attempt) {
      const auto place = place_around(uniform(random_, -2.2, 2.2), uniform(random_, 1.5, 3.5));
      if (place && go(*place, 1.2, kMargin)) return;
    }
  }

  const Room& room_;
  const ChairTake& take_;
};

}  // namespace

std::optional<LifePlan> plan_chair_life(const Room& room, const FreeSpace& floor, const ChairSubject& subject,
                                        const ChairTake& take, std::mt19937_64& random) {
  return ChairPlanner(room, floor, subject, take, random).plan();
}

}  // namespace inhabit
