#pragma once
#include <array>

#include "inhabit/synth/chair_life.h"
#include "inhabit/synth/life_writer.h"
#include "inhabit/synth/seat_touch.h"

namespace inhabit {

/// Writes a stay on a chair: sitting down with the hands of an interaction type, what is done while seated, getting up.
class SittingWriter : protected LifeWriter {
 public:
  /// All must outlive this.
  SittingWriter(const Furniture& chair, const FreeSpace& floor, const ChairSubject& subject, std::mt19937_64& random)
      : LifeWriter(floor, *subject.figure, random), chair_(chair), subject_(subject) {}

 protected:
  /// From `stay.down`, which is now, to getting up at `stay.rise`, with the hands of `take`. False where a hand finds
  /// no place on the chair.
  /// @param leaves whether getting up is seen.
  bool live_on(const Seat& seat, const SeatStay& stay, const ChairTake& take, bool leaves);

  const Furniture& chair_;       ///< that is sat on
  const ChairSubject& subject_;  ///< who sits

 private:
  struct Contact {
    SeatPart part = SeatPart::arm_rest;
    HandTrip trip;
  };
  /// What is known of a stay while it is written.
  struct Stay {
    const Seat& seat;
    const SeatStay& times;
    std::array<bool, 2> may_touch{};     ///< hands of the interaction type
    std::array<double, 2> busy_until{};  ///< second at which a hand has left what it holds
    bool lively = false;                 ///< free interactions
    const std::vector<SeatPart>& parts;  ///< ChairTake::parts
  };

  std::optional<Contact> find_contact(const Stay& stay, int side);
  /// How the trunk bends and leans for hands to be at all of `contacts`, no more than it must; false where no posture
  /// does.
  bool find_posture(const Stay& stay, const std::vector<Contact>& contacts, TrunkMove& posture) const;
  /// The hand of `side` goes to `contact` before the pelvis comes to rest and stays a while; the trunk prepares it.
  void reach_while_sitting_down(Stay& stay, const Contact& contact, const TrunkMove& posture, bool alone,
                                double held_until);
  void rest_on_thigh(Stay& stay, int side, bool held_until_rise);
  void push_off(const Stay& stay, const Contact& contact);
  void pass_time(Stay& stay, double from, double until);
  double touch_again(Stay& stay, double t, double until);
  double move_legs(Stay& stay, double t, double until, TrunkMove& move);
  void hand_on_crossed_leg(Stay& stay, const LegMove& move);
  void shift(const Stay& stay, TrunkMove& move);
  void hands_behind_head(double from, double until, TrunkMove& move);

  double legs_free_ = 0;  ///< second at which the feet are back
};

}  // namespace inhabit
