#pragma once
#include <torch/types.h>

#include <array>
#include <string>
#include <vector>

#include "inhabit/body/skeleton.h"

namespace inhabit {

/// How the file that a clip was read from puts things. Who writes the clip into a file of the same format puts them
/// so again (io/files.h); to a clip in memory it means nothing.
struct FileConventions {
  std::string format;                   ///< "bvh", "smpl" (AMASS and its family), "npz"; empty: none of these
  double metres_per_unit = 1;           ///< of a .bvh
  bool z_up = false;                    ///< else +Y is up
  std::vector<std::string> channels;    ///< of a .bvh's joints, in order: x y z positions, X Y Z rotations ("xyzZXY")
  int carrier = -1;                     ///< joint that carried the body where the root stood (motion/locomotion.h)
  std::array<double, 3> root{};         ///< where that root stood, metres, +Y up
  std::array<double, 3> root_offset{};  ///< OFFSET of a .bvh's root, in the file's unit and axes: its rest pose
};

/// One person's motion and what is annotated on it. Metres, seconds, radians, +Y up, the person faces +Z at rest.
/// A tensor that is not known is undefined. `joints` is always there; rotations and trans may be missing (positions
/// only).
struct Clip {
  Skeleton skeleton;        ///< J joints, at rest
  double rate = 30.0;       ///< frames a second
  torch::Tensor joints;     ///< (T, J, 3) metres, world
  torch::Tensor rotations;  ///< (T, J, 3) axis-angle radians, each joint relative to its parent; row 0 is root_orient
  torch::Tensor trans;      ///< (T, 3) metres: root joint = trans + skeleton.offsets[0] (the SMPL convention)
  /// (T, J, 3) metres, relative to the parent, in its frame: what stands in place of skeleton.offsets where joints
  /// translate. Row 0 is offsets[0] in every frame (the root moves by trans). Undefined: the bones are rigid.
  torch::Tensor translations;
  torch::Tensor betas;             ///< (B) body shape
  std::string gender = "neutral";  ///< "male", "female" or "neutral", as SMPL's family of files names it
  std::string source_body;  ///< body model of the file it came from ("smplx", "smplh"), empty for the built-in body
  torch::Tensor
      source_betas;      ///< (B) shape in that model's own space, kept for writing; the built-in body cannot use it
  FileConventions file;  ///< of the file that it was read from

  std::vector<std::string> action_names;  ///< labels that `action` indexes
  torch::Tensor action;                   ///< (T) int64
  torch::Tensor contact;                  ///< (T, J) float 0/1: the joint's skin touches the scene
  torch::Tensor hand_targets;             ///< (T, 2, 4) left, right: world x y z metres of the touched point, then 0/1
  std::vector<std::string> object_names;  ///< names of the scene's objects that object_pose rows belong to
  torch::Tensor object_pose;              ///< (T, O, 6) world translation metres, then axis-angle radians

  /// T; 0 without joints.
  int64_t frames() const { return joints.defined() ? joints.size(0) : 0; }
  /// How long it lasts, a frame being as long as it is shown.
  double seconds() const { return static_cast<double>(frames()) / rate; }
  /// (T, 3) metres: where the root joint goes.
  torch::Tensor root_path() const { return joints.select(1, 0); }
};

/// The person of a clip, who does nothing yet: skeleton, rate, shape, gender, source and conventions of the file.
Clip person_of(const Clip& clip);

/// The poses at `frames`, one after the other: motion alone, where there are rotations with them.
Clip frames_at(const Clip& clip, const std::vector<int64_t>& frames);

/// Frames [first, last) with every annotation that is there.
Clip slice(const Clip& clip, int64_t first, int64_t last);

/// Throws Error(subject, ...) unless the clip has a frame, its sizes agree, every number is finite and the rate is in
/// (0, 1000].
void validate(const Clip& clip, const std::string& subject);

}  // namespace inhabit
