#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/motion/clip.h"
#include "inhabit/progress.h"
#include "inhabit/scene/scene.h"

namespace inhabit::refine {

class SharedSurroundings;

/// A point of the body that is at a place in frames [first, last].
struct GivenContact {
  int joint = 0;                                     ///< of the standard skeleton
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< metres, in the joint's frame
  Eigen::Vector3d place = Eigen::Vector3d::Zero();   ///< metres, world
  int64_t first = 0;                                 ///< frame of the clip in which it begins
  int64_t last = 0;                                  ///< frame of the clip in which it ends, included
};

/// What is wanted of a refined motion.
struct Options {
  bool contacts = true;  ///< find contacts of the feet and keep feet in place while they last
  /// (T, 4) probabilities that kFootJoints are in contact, where a network predicts them; undefined: contacts are
  /// found in the motion.
  torch::Tensor feet;
  bool hands = true;                 ///< find those of hands with the scene too
  std::vector<int64_t> keep_frames;  ///< frames, as the clip counts them, that come out exactly as they are
  /// Joints of the standard skeleton whose places are kept, to some millimetres where the rest is noisy.
  std::vector<int> keep_joints;
  double keep_within = 0.0001;  ///< metres: standard deviation of these places
  /// Metres that the skin of the built-in body may be in the scene. Without it balls stand for the body
  /// (scene_terms.h), and what it sits, leans or rests on may be 3 cm in them.
  std::optional<double> skin_depth;
  std::vector<GivenContact> given;  ///< contacts that are known, of hands above all
  /// A network made the motion: its poses are believed to 3 degrees and 2 cm, and feet that glide by up to 15 cm are
  /// taken for standing.
  bool generated = false;
  double foot_change = 4;       ///< m/s^2, of what is changed of the feet; less: they leave and land more softly
  double smooth = 1;            ///< factor on how smooth the motion is; 0: no smoothing, contacts alone
  std::string name = "motion";  ///< what errors call the clip
  bool standard = false;        ///< the motion is wanted on the standard skeleton alone
  Progress progress = {};       ///< solves of stretches of the motion; may be empty
};

/// Adds what --keep names: frames ("0,60,90"), every so many and the last ("every:60"), joints by their
/// standard names or those of the clip's skeleton ("left_wrist"), mixed as one likes, between commas. Throws Error
/// naming the part that is none of these, with the joints that there are.
void add_kept(const std::string& what, const Clip& clip, Options& options);

/// What was found and done.
struct Result {
  Clip before;     ///< the motion as it was, on the standard skeleton
  Clip clip;       ///< on the standard skeleton, at the motion's own rate
  Clip on_source;  ///< the same on the clip's own skeleton (motion/transfer.h), kept frames bit by bit; empty
                   ///< where Options::standard is set
  double noise_rotations = 0;  ///< radians, median over the joints: white noise found in the motion
  double noise_root = 0;       ///< metres
  int64_t contacts = 0;        ///< of balls of the feet and heels
  /// Contacts of palms that were found on the scene's surfaces, of joints 20 (left wrist) and 21. `clip` and
  /// `on_source` have them as Clip::hand_targets, where the motion brought none of its own.
  std::vector<GivenContact> hands;
  double moved = 0;  ///< metres, mean distance of the joints from where they were
};

/// A clean motion from a noisy or sliding one: smooth as far as it is noisy, feet that stand and hands that rest where
/// they are in contact, no joint beyond its limits, nobody inside the scene.
/// @param clip on any skeleton that maps to the standard one (retarget), at any rate.
/// @param scene may be empty: then a flat floor is assumed under the feet.
/// Throws Error for what cannot be retargeted and options that name no frame or joint.
Result refine(const Clip& clip, const Scene& scene, const Options& options = {});

/// A network's continuation of observed poses, refined as generated motion: it goes on from the last ten frames
/// of them, which stay as they are. On the standard skeleton.
/// @param past, future on one skeleton, at one rate, with rotations
/// @param surroundings of the scene, empty or not, which all continuations in it share (scene_terms.h)
Clip refine_continuation(const Clip& past, const Clip& future, const SharedSurroundings& surroundings);

}  // namespace inhabit::refine
