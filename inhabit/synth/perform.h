#pragma once
#include "inhabit/synth/life_plan.h"

namespace inhabit {

/// Motion and what is known about it, one entry a frame.
struct Performance {
  std::vector<Posed> pose;     ///< of the figure
  std::vector<Action> action;  ///< what is done
  std::vector<int> seat;       ///< index of the furniture sat on, on the way to it or from it; -1 without one
  std::vector<std::array<bool, kStandardJoints>> contact;   ///< as Clip::contact
  std::vector<std::array<Eigen::Vector4d, 2>> hand_target;  ///< world point, then 1 while touched
};

/// Plays `frames` frames of a plan, the first at time `from` seconds.
Performance perform(const Figure& figure, const LifePlan& plan, double from, int frames, double rate,
                    std::mt19937_64& random);

}  // namespace inhabit
