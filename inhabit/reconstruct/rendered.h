#pragma once
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "inhabit/reconstruct/reconstruct.h"
#include "inhabit/synth/room.h"

namespace inhabit::reconstruct {

/// What is wrong with what networks would have made of a video, so that it is known.
struct KnownErrors {
  double scale = 0.4;         ///< of depth, metres a raw unit: raw = (metric - offset) / scale
  double offset = 0.6;        ///< of depth, metres
  double noise = 0.01;        ///< part of the depth, standard deviation at each pixel
  double warp = 0.01;         ///< the same, smooth over the image, anew in each frame
  int maps = 3;               ///< of each frame; they differ in noise and at the edges of things
  double root_along = 0.06;   ///< metres, standard deviation of the root along the line of sight
  double root_across = 0.02;  ///< metres, the same across it, each direction
  double drift = 0.08;        ///< metres, slow error of the root along the line of sight
  double pose = 2;            ///< degrees in each component of every rotation
};

/// What images are rendered.
struct RenderOptions {
  int64_t width = 320;   ///< pixels of a row
  int64_t height = 240;  ///< pixels of a column
  double field = 75;     ///< degrees from left to right
  /// An object is one of the inputs where so many pixels are its own in the first frame, and `least_seen` of it is
  /// seen.
  int64_t fewest_pixels = 400;
  /// Part, 0 to 1, of the side that an object turns to the camera: the rest is outside the image or behind something.
  double least_seen = 0.6;
  KnownErrors errors;  ///< what is wrong with the inputs
};

/// An object's true place.
struct TrueObject {
  std::string name;     ///< as ObjectInput has it
  Placement placement;  ///< of the input's meshes, with which they stand as in the room
};

/// What a camera would have seen of somebody in a room, as inputs of run() with known errors, and the truth.
struct Rendered {
  Inputs inputs;                    ///< of run()
  Clip truth;                       ///< the person's motion, in the room's world
  Scene room;                       ///< everything that is in it, metres
  KnownErrors errors;               ///< what the inputs were made with
  std::vector<TrueObject> objects;  ///< as inputs.objects
};

/// Renders by rays. The camera stands in a corner or at a wall of the room, from where most of the body is seen, and
/// looks at the middle of its path. Object meshes are the room's furniture in other units, rotated and shifted. Images
/// are made when they are read. The same seed gives the same images.
Rendered render_life(const Room& room, const Clip& life, const RenderOptions& options, uint64_t seed);

/// Writes a rendering as the files that `inhabit reconstruct` reads: estimated.npz, camera.json, depth_000000.npy, ...,
/// mask_000000.png, ..., objects/NAME.glb, object_masks/NAME_000000.png, and the truth: truth.npz, room.glb.
void write_rendered(const Rendered& rendered, const std::string& folder);

}  // namespace inhabit::reconstruct
