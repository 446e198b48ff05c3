#pragma once
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/interact/live_person.h"
#include "inhabit/serve/frames.h"
#include "inhabit/serve/message.h"
#include "inhabit/serve/world.h"

namespace inhabit::serve {

/// What happens to a person besides poses: told to the page once.
struct Contacts {
  std::string chair;          ///< that is sat on or walked to; empty: none
  interact::HandContacts at;  ///< left, right
};

/// One page's person: a LivePerson, or a motion of in-betweening that they carry out, at 30 frames a second. Knows
/// nothing of connections. Not for several threads at once.
class Character {
 public:
  /// Stands at World::person's place.
  explicit Character(std::shared_ptr<const World> world);

  // Each throws Error saying why it cannot be done; the person then goes on as they did, or stays where no route leads.
  /// To a place on the floor (x, z).
  void walk(const Eigen::Vector2d& to);
  /// On a seat, by its name.
  void sit(const std::string& chair);
  /// A contact on a seat that is not sat on or walked to sends the person there.
  void touch(const Touch& touch);
  /// ContactNet's contacts on the seat, other ones with each call.
  void draw();
  /// Gets up, or stops walking.
  void stand();
  /// Stands where everybody begins.
  void restart();

  /// Carries out a motion on the standard skeleton, 30 frames a second, that begins near the present pose.
  void play(const Clip& motion);

  /// One frame on.
  void step();

  /// The present pose.
  const Frame& frame() const { return frame_; }
  /// What the page is told beside it; whether it is recorded, and the last message, the connection knows.
  Status status() const;
  /// Seat and contacts that are aimed at.
  const Contacts& contacts() const { return contacts_; }
  /// A motion is carried out; its last pose is held until something else is asked for.
  bool playing() const { return at_ < motion_.size(); }

  /// The last `seconds` as a motion: what previews observe. The first pose is held where there was less.
  Clip recent(double seconds) const;
  /// What everybody shares.
  const World& world() const { return *world_; }

 private:
  void become(const Frame& frame);  ///< a LivePerson who stands still in this pose
  void leave_motion();
  void go_to(const Eigen::Vector2d& place, double heading);
  void stop_at_place();
  void walk_on();
  void blend_from_here();
  void reach();
  void live_step();
  bool seated() const;
  const Seat& seat_for(const std::string& chair) const;

  std::shared_ptr<const World> world_;
  std::unique_ptr<interact::LivePerson> live_;
  bool senses_ = false;                            // the LivePerson knows the scene
  std::optional<Eigen::Vector2d> walking_to_;      // place on the floor
  std::unique_ptr<interact::LivePerson> walking_;  // who still walks while live_ already stands, for kStop frames
  int stopping_ = 0;                               // frames of these
  Contacts contacts_;
  bool reach_soon_ = false;  // contacts were moved since the hands were told
  uint64_t draws_ = 0;
  uint32_t index_ = 0;
  Frame frame_;
  std::deque<Frame> past_;
  std::vector<Frame> motion_;  // that is carried out
  size_t at_ = 0;              // in it
  Frame left_from_;            // pose that what comes is blended from
  int blending_ = 1000;        // frames since that began
};

}  // namespace inhabit::serve
