#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/synth/life.h"

namespace inhabit {

/// What the hands do when somebody sits down: the interaction types of the COUCH data set (its Table 4).
enum class Interaction { right_hand, left_hand, both_hands, no_contact, free, locomotion };
/// "right_hand", "left_hand", "both_hands", "no_contact", "free", "locomotion".
const std::vector<std::string>& interaction_names();

/// Where a hand takes hold of what one sits on.
enum class SeatPart { arm_rest, seat_front, seat_side, back_rest };
/// "armrest", "front", "side", "back", as interact::contact_areas() has them.
const std::vector<std::string>& seat_part_names();

/// Somebody with a shape and a style of their own.
struct ChairSubject {
  torch::Tensor betas;                   ///< (B) shape
  std::shared_ptr<const Figure> figure;  ///< of that shape
  GaitStyle gait;                        ///< how they walk
  Manner manner;                         ///< how they move otherwise
  double early = 0.4;                    ///< seconds before sitting down at which a hand sets out for the chair
  double trunk = 1;                      ///< scales how far the trunk turns and leans towards what a hand reaches for
  double looks = 0.5;                    ///< how often the eyes go there first
  double walks_off = 0.5;                ///< how often there is an end to sitting
};
/// Draws a person at random: shape, gait, manner and habits at chairs.
ChairSubject draw_subject(const BodyModel& body, std::mt19937_64& random);

/// What one clip shows. Room::furniture[0] is the chair.
struct ChairTake {
  Interaction interaction = Interaction::no_contact;  ///< what the hands do
  double seconds = 15;                                ///< length of the clip
  double direction = 0;  ///< of the start seen from the chair, radians from its front towards its left
  double distance = 2;   ///< of the start from the chair's middle, metres; farther where that is not free
  double before = 0;     ///< seconds that somebody stands about before setting off, beside up to one
  double after = 0;      ///< seconds left to stand about after walking off; 0: whoever does stands for two or less
  std::vector<SeatPart> parts = {};  ///< that hands take hold of, each as often; empty: what people do on such a seat
};

/// A clip of `take`: somebody walks to the chair, around it where they start behind, sits down with the hands of the
/// take's type at parts of the chair, lives on it, and often stands up and walks off; or only walks about (locomotion).
/// A hand that touches sets out before the person sits down and has arrived when the pelvis does. No other hand touches
/// the chair, except in free interactions.
/// Drawn again until nothing is wrong: joint limits, capsules in furniture (in the seat in use: arms, shanks, feet and
/// trunk too), contacts that are planned and not reached. Nothing when no draw was without a fault.
std::optional<Clip> sit_on_chair(const Room& room, const FreeSpace& floor, const BodyModel& body,
                                 const ChairSubject& subject, const ChairTake& take, std::mt19937_64& random);

}  // namespace inhabit
