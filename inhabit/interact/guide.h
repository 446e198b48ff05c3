#pragma once
#include <optional>

#include "inhabit/interact/chair.h"
#include "inhabit/interact/state.h"
#include "inhabit/scene/walk_path.h"

namespace inhabit::interact {

/// Leads a person along a way: a rule after the networks. The goal stays what they are to do at the end, as in
/// training; the trajectory that PoseNet predicted for the next second, which is its input of the next frame, is drawn
/// to the way. Positions, directions and the share of walking t seconds ahead move by kDrawn sqrt(t) of what
/// they are off, where that trajectory is of somebody who walks; by less where they hardly move.
class Guide {
 public:
  /// @param way begins where the person is
  explicit Guide(WalkPath way) : way_(std::move(way)) {}

  /// All of it, from where it began.
  const WalkPath& way() const { return way_; }
  double left() const { return way_.total() - along_; }  ///< metres still to go

  /// The person is here (x, z), metres: at most half a metre of the way is left behind at once.
  void follow(const Eigen::Vector2d& here);
  /// Draws the trajectory of the next second to what is left of the way.
  void draw(State& state) const;

 private:
  static constexpr double kDrawn = 0.8;
  WalkPath way_;
  double along_ = 0;
};

/// Draws the next second of somebody who is before a seat, at most 1 m from it, to the line on which one sits down: to
/// the side alone, sqrt(t) of what they are off.
void draw_before(const Chair& chair, State& state);

/// Draws the next second of somebody who has arrived to the place where they are to stay: sqrt(t) of what they are off.
void hold(const Eigen::Vector2d& place, State& state);

}  // namespace inhabit::interact
