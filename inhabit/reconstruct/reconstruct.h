#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/progress.h"
#include "inhabit/reconstruct/align_depth.h"
#include "inhabit/reconstruct/camera.h"
#include "inhabit/reconstruct/images.h"
#include "inhabit/reconstruct/key_root.h"
#include "inhabit/reconstruct/place_object.h"

namespace inhabit::reconstruct {

/// An object as its own networks made it.
struct ObjectInput {
  std::string name;          ///< what its meshes are called in the scene, and errors call it
  std::vector<Mesh> meshes;  ///< own axes, +Y up, any unit
  ImageSequence masks;       ///< where it is seen; one for all frames only where the camera does not move
};

/// What networks made of a video.
struct Inputs {
  Clip motion;    ///< of the person, as estimated: joint rotations and trans, on any skeleton that maps to the standard
                  ///< one
  Camera camera;  ///< what all images are seen by
  ImageSequence depth;               ///< raw maps of some or all frames, (K, height, width) each, see combined()
  ImageSequence masks;               ///< (height, width) bool of each frame with depth at least: where the person is
  std::vector<ObjectInput> objects;  ///< that are to be placed in the room; may be empty
};

/// How a recording is reconstructed.
struct Options {
  const BodyModel* body = nullptr;  ///< whose skin was seen; null: the built-in one
  int64_t key_step = 5;             ///< frames (of 30 a second) from one optimised key frame to the next
  int64_t keep_every = 3;           ///< of these, the keys that motion is made between
  double uncertainty = 0.05;        ///< see combined()
  double jump = 0.05;               ///< see metric_depth()
  double cell = 0.03;               ///< metres: the scene's points are this far apart
  bool floor_scale = true;          ///< the floor tells the depth's scale too, see align_depth
  KeyRootOptions roots;             ///< how key frames are moved (supplement 8.2)
  int64_t steps = 0;                ///< evaluations of the denoiser; 0: the model's own
  uint64_t seed = 1;                ///< what the noise follows from that motion begins as
  std::string name = "motion";      ///< what errors call the motion
  bool standard = false;            ///< the motion is wanted on the standard skeleton alone
  bool collisions = false;          ///< Result::collides is found
  Progress progress;                ///< depth maps read; may be empty
};

/// The motion, the room, and what was found out on the way. World, +Y up, metres.
struct Result {
  Clip before;                      ///< the estimate on the standard skeleton, in the world that results are in, +Y up
  std::vector<int64_t> moved_keys;  ///< frames of `before` whose roots were optimised
  Clip keys_moved;                  ///< the same with its root as key frames were moved, linear in between
  Clip motion;                      ///< the result on the standard skeleton, 30 frames a second
  Clip on_source;  ///< the same on the motion's own skeleton at its rate; empty where Options::standard is set
  std::vector<int64_t> keys;          ///< frames of `motion` that it was made between
  Clip key_poses;                     ///< the poses asked for there
  Scene scene;                        ///< floor and objects as meshes, everything else that was seen as points
  DepthAlignment depth;               ///< scale and offset of the depth maps, and how well they are known
  std::vector<PlacedObject> objects;  ///< as Inputs::objects, each in its place
  double floor = 0;                   ///< metres, height
  double moved = 0;                   ///< metres, mean distance that key frames' roots were moved
  int64_t contacts = 0;               ///< vertices of key frames in contact
  torch::Tensor collides;             ///< (frames of `motion`) bool; undefined unless asked for
  std::vector<Immersion> immersions;  ///< of each stretch of `collides`
  std::vector<std::string> notes;     ///< what the user should know, one clause each
};

/// A person's motion and the room around them, in metres, from what networks made of a video (supplement 8 of the
/// in-betweening paper): depth in metric scale and objects in place (8.1); key frames with better places, and motion
/// made anew between every few of them by a noise-aware model (8.2). Depth maps are read one at a time, twice. The same
/// input gives the same result. Throws Error naming the input that is wrong or does not fit the others.
Result run(const Inputs& inputs, const inbetween::SceneInbetweener& inbetweener, const Options& options = {});

}  // namespace inhabit::reconstruct
