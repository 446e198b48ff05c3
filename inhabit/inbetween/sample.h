#pragma once
#include <torch/types.h>

#include <memory>
#include <string>
#include <vector>

#include "inhabit/data/window_set.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/query.h"

namespace inhabit::inbetween {

struct Config;

/// One window of motion in its scene, in the canonical frame of its first pose.
struct Sample {
  torch::Tensor features;    ///< (T, 201)
  torch::Tensor occupancy;   ///< (side / 2, side, side): up, left, ahead; 1 occupied, -1 free
  torch::Tensor floor;       ///< (96, 96) of scene_floor
  torch::Tensor offsets;     ///< (T, A, 3) metres from the body's anchors to the nearest place of the scene
  torch::Tensor body_shape;  ///< (7)
  torch::Tensor bones;       ///< (22, 3) metres, the skeleton's offsets
};

/// A stretch of recorded motion in its scene.
struct Window {
  std::string name;                    ///< "clips/000012.npz 30", in errors
  Clip truth;                          ///< on the standard skeleton, with rotations
  Clip conditioning;                   ///< source of the key frames: the truth, or noisy poses; set by the evaluation
  std::shared_ptr<const Scene> scene;  ///< none: nothing to collide with
};

/// The clip's shape of the built-in body: its betas, or where it has none those that fit its bones.
torch::Tensor body_betas(const Clip& clip);

/// `count` anchors (T, A, 3) on the skin of the built-in body of that shape in a clip's poses, metres, by furthest
/// point sampling at rest; its root joint stands at the clip's. Throws Error where the skin has fewer vertices.
torch::Tensor anchor_positions(const Clip& clip, int64_t count);

/// What the global encoder sees of a scene: (side / 2, side, side).
/// @param root (3) metres, the first frame's root joint; @param yaw radians that it faces; @param side cells of 0.1 m
torch::Tensor scene_occupancy(const SceneQuery& scene, const torch::Tensor& root, double yaw, int side);

/// Windows of clips in rooms, read from native data sets as they are asked for. What a clip's windows need of its scene
/// is worked out when the first is asked for and then kept: 138 KB for each clip, 8 KB for each window with the paper's
/// sizes. Safe to use from several threads.
class Data {
 public:
  /// Windows of config.frames frames, one every `stride`, of every clip of `split` ("train", "val", "test" or "all")
  /// that has a scene and is long enough.
  Data(const std::vector<std::string>& folders, const std::string& split, const Config& config, int64_t stride);
  ~Data();
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;

  const WindowSet& windows() const;                  ///< where the windows are in the data sets
  int64_t size() const { return windows().size(); }  ///< how many windows there are
  Sample sample(int64_t index) const;                ///< what is trained on
  torch::Tensor features(int64_t index) const;       ///< a sample's features alone

  /// The window itself, as recorded, with its scene.
  Window window(int64_t index) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::inbetween
