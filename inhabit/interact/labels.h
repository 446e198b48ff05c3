#pragma once
#include <torch/types.h>

#include <string>
#include <vector>

#include "inhabit/interact/chair.h"
#include "inhabit/motion/clip.h"

namespace inhabit::interact {

/// What a recording says about how the person gets on a chair, one row a frame (T). Hands: left, right. World, metres.
struct Labels {
  torch::Tensor action;        ///< (T, 3) idle, walk, sit: weights that sum to 1, changing over half a second
  torch::Tensor global_phase;  ///< (T) cycles since the start, never falling; its fraction is the phase. Walking: 0
                               ///< where the left foot is put down, 0.5 the right one; sitting down goes from one
                               ///< whole number to the next, and so does standing up; else it rests
  torch::Tensor hand_phase;    ///< (T, 2) 0 where a hand leaves for a contact, 1 when it is there and while it stays
  torch::Tensor hand_target;   ///< (T, 2, 4) the contact, then 1 while it is being reached for or held; else zeros
  torch::Tensor seated;        ///< (T) 1 from when the pelvis comes to rest on the seat until they begin to rise
  torch::Tensor goal;          ///< (T, 3) where the root is to get to: pelvis above the seat's surface, else the floor
  torch::Tensor goal_direction;  ///< (T, 3) unit, level: which way to face there
  torch::Tensor goal_action;     ///< (T, 3) what to do there: idle, walk or sit, one of them 1
};

/// Actions of labels and of generated motion, as Clip::action_names has them.
inline const std::vector<std::string> kActionNames = {"idle", "walk", "sit"};

/// Metres to a place on the floor that somebody walks to within which they have arrived.
inline constexpr double kArrived = 0.3;

/// Labels of a clip on the standard skeleton whose chair is known (chair_of). Seated frames are those of stays_of,
/// other actions those of Clip::action by name, or walking above 0.3 m/s where it is unknown. The goal is where they
/// stand until they begin to move, then the next seat until they begin to rise; then where they walk to, "walk" until
/// they have arrived, then "idle". Reaching for a contact begins at the last local minimum of the hand's speed
/// before it, at most 1.5 s before.
/// @param chair nothing: nobody sits.
Labels label(const Clip& clip, const std::optional<Chair>& chair);

}  // namespace inhabit::interact
