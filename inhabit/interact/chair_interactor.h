#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/interact/live_person.h"
#include "inhabit/progress.h"
#include "inhabit/scene/scene.h"

namespace inhabit::interact {

/// What the person is to do.
struct Options {
  std::string chair;  ///< object of the scene, "armchair_0"; empty: its only seat, or of several the nearest
  std::optional<Eigen::Vector4d> sit_at;  ///< x y z metres, then radians: any place to sit on instead
  /// One after the other: the next are given once the present ones are reached. None: hands are free.
  std::vector<HandContacts> contacts;
  double hold = kHold;         ///< seconds that hands stay at each of the contacts; infinity: at the last to the end
  bool draw_contacts = false;  ///< ContactNet draws them
  bool raw = false;            ///< the networks' motion as it is: the one before does not fade into it, nor is it
                               ///< fitted to contacts and scene (fit_contacts.h)
  bool straight = false;       ///< no route is planned around what stands in the way (route.h)
  bool force = false;          ///< a seat that is too high or low, a contact that is out of reach: tried all the same
  /// x, z metres and heading: where they walk in the end, once the last contacts were held and they have sat for two
  /// seconds.
  std::optional<Eigen::Vector3d> then_walk;
  bool standard = false;       ///< the motion is wanted on the standard skeleton alone
  double seconds = 16;         ///< of motion
  uint64_t seed = 1;           ///< of contacts that are drawn
  std::string name = "start";  ///< what errors call the clip
  Progress progress = {};      ///< frames that the networks have moved the person; may be empty
};

/// What the person does.
struct Result {
  Clip motion;     ///< on the standard skeleton, 30 frames a second, from the pose that was given on
  Clip on_source;  ///< what follows on that pose on the clip's own skeleton, at its rate (motion/transfer.h); empty
                   ///< where Options::standard is set
  Chair chair;     ///< that they sit on
  std::vector<HandContacts> contacts;  ///< that were reached for, on the surface
  /// (contacts, left and right) metres: the palm's closest approach to each contact (ACE); none without one
  std::vector<std::array<std::optional<double>, 2>> contact_error;
  std::optional<int64_t> seated;  ///< first frame from which the person sits, to the end or until they leave
  /// Metres from where they end to Options::then_walk, infinite where they never got up to go; none without one.
  std::optional<double> walk_error;
};

/// Controllable human-chair interaction (COUCH): a person, a chair and where the hands are to go in, motion out. On the
/// CPU. Safe to use from several threads.
///
///   const auto interactor = interact::ChairInteractor::load("interact-compact.safetensors");
///   interact::Options options{.chair = "armchair_0", .draw_contacts = true};
///   interact::Result r = interactor.run(interact::standing_clip({2.5, 1}, 0), scene, options);   // r.motion
class ChairInteractor {
 public:
  /// @param predictor what moves the person: PoseNet under ControlNet, or what it is compared with.
  explicit ChairInteractor(const Networks& networks, Predictor predictor = Predictor::pose);
  /// Throws Error naming the file where it is no model of interaction.
  static ChairInteractor load(const std::string& path);
  ~ChairInteractor();
  ChairInteractor(ChairInteractor&&) noexcept;  ///< what was moved from may only be destroyed

  /// Sizes and settings that the networks were made with.
  const Config& config() const;
  /// The networks as they run, for LivePerson.
  const Engine& engine() const;

  /// @param start a person whose last frame is where they begin, on any skeleton that maps to the standard one. Without
  /// frames they stand before the chair, 2 m from it or as near to that as there is room (standing_before).
  /// @param scene as read, with the chair. Contacts are moved to the nearest place of the chair's surface. Throws Error
  /// where an option is out of range, the scene has no such chair or seat, a contact is over 10 cm from the chair or
  /// farther from the seat than arms reach, the person begins inside something, there is no route to the chair or on
  /// from it, they are to walk over 3 m out of the scene, or the model lacks ContactNet where contacts are to be drawn.
  Result run(const Clip& start, const Scene& scene, const Options& options) const;

  /// So many motions onto the same chair, with seeds from options.seed on: where contacts are drawn, others each time.
  /// options.progress counts the frames of all. @param samples 1 to 1000; Throws Error("samples", ...) else.
  std::vector<Result> run_samples(const Clip& start, const Scene& scene, const Options& options, int64_t samples) const;

  /// One motion onto a chair that is known, from a start that has frames.
  Result run_on(const Clip& start, const Scene& scene, const Chair& chair, const Options& options) const;

  /// The chair that run() takes: to find contacts on it before. @param start without frames: the person is to be placed
  /// before it, so that it is the seat nearest to the scene's origin.
  Chair chair_of(const Clip& start, const Scene& scene, const Options& options) const;

  /// Contacts that ContactNet proposes on a chair (sec. 4.4), moved to its surface; those over 10 cm from it or under
  /// 10 cm above the floor are dropped (appendix 3). @param count draws, one for each numbered seed, 100,000 at most;
  /// Throws Error("count", ...) else.
  std::vector<HandContacts> draw_contacts(const Chair& chair, int64_t count, uint64_t seed) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::interact
