#pragma once
#include <optional>
#include <random>

#include "inhabit/synth/chair_life.h"
#include "inhabit/synth/life_plan.h"
#include "inhabit/synth/room_space.h"

namespace inhabit {

/// What happens in one clip of `take`, from its first second on. Nothing where this draw does not fit: no route to the
/// chair, no place for a hand, or the take is over before the person has sat for three seconds.
std::optional<LifePlan> plan_chair_life(const Room& room, const FreeSpace& floor, const ChairSubject& subject,
                                        const ChairTake& take, std::mt19937_64& random);

}  // namespace inhabit
