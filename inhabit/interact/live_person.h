#pragma once
#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "inhabit/body/bones.h"
#include "inhabit/interact/engine.h"
#include "inhabit/interact/features.h"
#include "inhabit/interact/settle.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/walk_path.h"

namespace inhabit::interact {

/// Contacts of the hands, left and right, world metres; none: the hand is free.
using HandContacts = std::array<std::optional<Eigen::Vector3d>, 2>;

/// Seconds that a hand stays at a contact before it lets go, as people of the training data do.
constexpr double kHold = 2;

/// A person who is moved frame by frame (sec. 4.5): PoseNet alone while they approach, ControlNet and PoseNet while
/// their hands go to contacts. 30 frames a second.
///
///   LivePerson person(engine, standing_clip(place, heading));
///   person.sit_on(chair, {left, right});
///   while (...) { person.step(); draw(person.pose()); }
class LivePerson {
 public:
  /// @param engine must outlive the person. @param start ends in their pose; of the second before it their velocity and
  /// trajectory are taken, where it has frames. 30 frames a second, standard skeleton with rotations. @param seed of
  /// what is drawn (habits while seated; SAMP).
  LivePerson(const Engine& engine, const Clip& start, uint64_t seed = 1);
  ~LivePerson();
  LivePerson(LivePerson&&) noexcept;  ///< what was moved from may only be destroyed

  /// Whether routes around what stands in the way are planned (route.h): as it is at first. Else they go as the
  /// networks have learned to.
  void plan_routes(bool plan);

  /// From now on they go to `chair` and sit down, hands at `contacts` while they do. Where there is no route they stay
  /// (blocked()).
  /// @param around what must not be walked into, the chair among it. @param hold seconds that hands stay at contacts;
  /// infinity: until they are given others.
  void sit_on(const Chair& chair, std::shared_ptr<const Surroundings> around, const HandContacts& contacts,
              double hold = kHold);
  /// Contacts of a person who sits, or other ones of one on the way. A hand on its way goes on to where its contact was
  /// moved to, by up to 25 cm; else it sets out anew.
  void reach_for(const HandContacts& contacts, double hold = kHold);
  /// They stand up, if they sit, and walk to a place on the floor (x, z), and face `heading` there. Where there is no
  /// route they stay (blocked()).
  void walk_to(const Eigen::Vector2d& place, double heading);

  /// One frame on.
  void step();

  const SettledPose& pose() const;  ///< of the present frame, on the person's bones
  const State& state() const;       ///< what the networks know of them
  /// Metres from a palm to its contact, while it has one.
  std::optional<double> contact_distance(int side) const;
  bool done(int side) const;  ///< the hand's contact was reached and let go, or there is none
  bool seated() const;        ///< the pelvis is on the seat
  bool off_seat() const;      ///< they have left it, or have none: who sits and shifts is neither seated() nor off
  bool blocked() const;       ///< there is no route to where they were last told to go
  /// The route that they are on; null where they go straight.
  const WalkPath* route() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Poses, a frame each, of the person of a clip (its skeleton and shape).
Clip clip_of(const std::vector<SettledPose>& poses, const Clip& person, double rate);

/// A person who stands with hanging arms: one frame. @param place (x, z) metres, on the floor y = 0; @param
/// heading radians from +Z towards +X; @param betas (B) shape or undefined.
Clip standing_clip(const Eigen::Vector2d& place, double heading, const torch::Tensor& betas = {});

}  // namespace inhabit::interact
