#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/interact/chair.h"
#include "inhabit/scene/query.h"

namespace inhabit::interact {

/// The level part of a seat around where the pelvis rests, in the chair's frame, metres.
struct SeatExtent {
  double front = 0;  ///< z
  double rear = 0;   ///< z
  double left = 0;   ///< x
  double right = 0;  ///< x, negative
};
/// How far a chair's seat reaches, found on its mesh in the axes of the seat.
SeatExtent seat_extent(const Chair& chair);

/// How a place near one chair is carried over to another.
struct Correspondence {
  bool from_side = false;  ///< as far from the edge on its side as before; else as far from the person
  bool from_rear = false;  ///< as far from the rear edge; else as far from the front edge, where the person is
};
/// Where a place lies at another chair, both in a frame whose origin is on the floor below the person: sideways and in
/// depth as `how` says, over the seat as high as before, below it in proportion of the heights.
Eigen::Vector3d corresponding(const Eigen::Vector3d& place, const SeatExtent& from, double from_height,
                              const SeatExtent& to, double to_height, const Correspondence& how);

/// A chair and the one that takes its place, in one frame: that of the old one, below where its person's pelvis rests.
struct ChairPair {
  Chair old;                                  ///< that the person sits on
  Chair fresh;                                ///< that takes its place
  SeatExtent old_seat;                        ///< of `old`
  SeatExtent fresh_seat;                      ///< of `fresh`
  Scene fresh_scene;                          ///< the new chair's meshes alone, by the old one's name
  std::unique_ptr<SceneQuery> old_surface;    ///< of `old` alone
  std::unique_ptr<SceneQuery> fresh_surface;  ///< of `fresh` alone

  /// Metres that the new seat is higher.
  double rise() const { return fresh.seat_height - old.seat_height; }
};

/// The object `name` of `chairs` where `old` stands: front edge where that one's is, so that shanks and feet are as far
/// from it as before, and sideways so that its person sits at the same fraction of its width, off both edges.
/// Throws Error as find_chair does.
ChairPair pair_chairs(const Chair& old, const Scene& chairs, const std::string& name);

/// Places on the new chair for points of the old one that a hand touches one frame after the other, and the rotation of
/// the surface.
struct CarriedTouch {
  std::vector<Eigen::Vector3d> points;                       ///< world, on the surface
  Eigen::Quaterniond tilt = Eigen::Quaterniond::Identity();  ///< of the new surface's normal against the old one's
};

/// Who touches, in the middle frame, world: on which side of a board the hand is, and what it must not be inside.
struct TouchingBody {
  Eigen::Vector3d wrist = Eigen::Vector3d::Zero();  ///< of the hand that touches
  std::array<Eigen::Vector3d, 2> hip;               ///< left, right
  std::array<Eigen::Vector3d, 2> knee;              ///< left, right
};

/// Carries points over by the correspondence whose places are nearest to the new surface, where that faces alike (the
/// top of an arm rest is no side of one), no more than 12 cm beside where they were, and not under a thigh. Nothing
/// where the points are on no surface of the old chair, or the new one has no such place within 12 cm.
std::optional<CarriedTouch> carry_touch(const ChairPair& chairs, const std::vector<Eigen::Vector3d>& points,
                                        const TouchingBody& body);

}  // namespace inhabit::interact
