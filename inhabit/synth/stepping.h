#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "inhabit/synth/curves.h"
#include "inhabit/synth/footsteps.h"
#include "inhabit/synth/posing.h"

namespace inhabit {

/// What the feet do to the body, one entry a frame.
struct Stepping {
  std::vector<std::array<FootControl, 2>> foot;  ///< left, right
  std::vector<std::array<bool, 2>> heel_down;    ///< left, right: the heel is on the floor
  std::vector<std::array<bool, 2>> ball_down;    ///< left, right: the ball is
  std::vector<Eigen::Vector2d> body;             ///< the root over the floor (x, z)
  std::vector<double> yaw;                       ///< the pelvis's heading without the rotation of each step
  std::vector<double> load;                      ///< fraction of the body's weight on the left foot, 0 to 1
  std::vector<double> stride;                    ///< left foot ahead of the right, metres; 0 at rest
  std::vector<double> stepping;                  ///< 1 while taking steps, 0 at rest, smooth between
  std::vector<double> jolt;   ///< vertical jolt of a landing foot, about 1 at its largest in brisk walking
  std::vector<double> speed;  ///< of the body, metres a second
};

/// Feet roll from heel to toe over their footholds and swing between them. The body follows as a linear inverted
/// pendulum over the centre of pressure p of the footholds: x - (h / g) x'' = p, solved for all frames at once, so that
/// it leans into steps before they come (Kajita et al. 2003 solve the same relation by preview control).
/// @param favour  while standing: -1 all weight on the right foot, 0 even, 1 all on the left; sampled by time.
Stepping step_tracks(const Figure& figure, const GaitStyle& style, const StepPlan& plan, const KeyCurve& favour,
                     int frames, double rate);

/// Highest root over the floor for each frame such that both legs reach their feet nearly straight; smooth.
/// @param yaw, list of the pelvis for each frame.
std::vector<double> root_height(const Figure& figure, const Stepping& stepping, const std::vector<double>& yaw,
                                const std::vector<double>& list);

}  // namespace inhabit
