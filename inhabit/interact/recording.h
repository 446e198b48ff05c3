#pragma once
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "inhabit/body/bones.h"
#include "inhabit/interact/chair.h"
#include "inhabit/interact/labels.h"
#include "inhabit/interact/state.h"
#include "inhabit/interact/voxels.h"
#include "inhabit/motion/clip.h"

namespace inhabit::interact {

/// A clip and its labels as what State is made of, a kilobyte a frame. World, metres.
struct Recording {
  /// One frame.
  struct Frame {
    Sample sample;                                  ///< its hands are where the palms are
    std::array<Eigen::Vector3f, kJoints> position;  ///< of the joints
    std::array<Eigen::Vector3f, kJoints> forward;   ///< axes +Z of the joints
    std::array<Eigen::Vector3f, kJoints> up;        ///< axes +Y of the joints
    std::array<Eigen::Vector3f, 2> contact;         ///< left, right
    std::array<bool, 2> wanted;                     ///< the hand goes to its contact or holds it
    std::array<float, kContacts> touching;          ///< 0 or 1, as OutputLayout::contacts
    bool seated;                                    ///< as Labels::seated
  };
  std::vector<Frame> frames;  ///< one after the other
  Bones bones;                ///< of the person
  double rate = 30;           ///< frames a second

  /// Number of frames.
  int64_t size() const { return static_cast<int64_t>(frames.size()); }
};

/// Needs the standard skeleton and rotations; Error(subject, ...) without.
Recording record(const Clip& clip, const Labels& labels, const std::string& subject);

/// Whether somebody stands about, with no goal or at it.
bool stands(const Recording::Frame& frame);

/// The state at a frame. Before its start and after its end the recording stands still.
State state_at(const Recording& recording, int64_t frame);

/// The state of somebody at the end of a motion whose second after it nobody knows: who walks goes on as in the last
/// sixth of a second, others stay. Goals are where they are. Needs what record() needs.
State state_after(const Clip& motion, const std::string& subject);

/// The image of a scene in the plane x = 0, as mirrored() of motion/mirror.h gives that of a clip.
Scene mirrored(const Scene& scene);

}  // namespace inhabit::interact
