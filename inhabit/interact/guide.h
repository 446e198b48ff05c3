#pragma once
#include <optional>

#include "inhabit/interact/chair.h"
#include "inhabit/interact/state.h"
#include "inhabit/scene/walk_path.h"

namespace inhabit::interact {

/// Guides a person along a route: a rule after the networks. PoseNet predicts the trajectory of the next second, which
/// is its input of the next frame. That trajectory is drawn to the route: t seconds ahead, positions, directions and
/// the weight of walking are moved by kDrawn sqrt(t) of what they are off; by less where the predicted trajectory is of
/// somebody who hardly moves. The goal is not changed: it stays the end of the route, as in training.
class Guide {
 public:
  /// @param route begins where the person is
  explicit Guide(WalkPath route) : route_(std::move(route)) {}

  /// All of it, from where it began.
  const WalkPath& route() const { return route_; }
  double left() const { return route_.total() - along_; }  ///< metres still to go

  /// The person is here (x, z), metres: at most half a metre of the route is left behind at once.
  void follow(const Eigen::Vector2d& here);
  /// Draws the trajectory of the next second to what is left of the route.
  void draw(State& state) const;

 private:
  static constexpr double kDrawn = 0.8;
  WalkPath route_;
  double along_ = 0;
};

/// Draws the next second of somebody who is before a seat, at most 1 m from it, to the line on which one sits down: to
/// the side alone, sqrt(t) of what they are off.
void draw_before(const Chair& chair, State& state);

/// Draws the next second of somebody who has arrived to the place where they are to stay: sqrt(t) of what they are off.
void hold(const Eigen::Vector2d& place, State& state);

}  // namespace inhabit::interact
