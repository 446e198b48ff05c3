#pragma once
#include <torch/types.h>

#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "inhabit/data/window_set.h"
#include "inhabit/forecast/config.h"

namespace inhabit::forecast {

/// One training or test window, in the axes of window_frame.
struct Sample {
  torch::Tensor joints;  ///< (P+T, J, 3) observed, then future
  torch::Tensor points;  ///< (N, 3) scene points within config.inference.radius of the origin
};

/// A mirror image or none, a change of size about the origin, a rotation about the vertical, then a shift on the floor.
struct Augmentation {
  torch::Tensor rotation;                                             ///< (3, 3)
  torch::Tensor shift;                                                ///< (3) metres
  bool mirror = false;                                                ///< in the plane x = 0
  double scale = 1;                                                   ///< of person and room alike
  torch::Tensor operator()(const torch::Tensor& positions) const;     ///< (..., 3)
  torch::Tensor joints(const torch::Tensor& positions) const;         ///< (..., J, 3): sides change places in a mirror
  torch::Tensor contacts(const torch::Tensor& contact_points) const;  ///< (..., J, 4), zeros where nothing touches
};

/// An angle in [0, pi) and a shift in [-0.5, 0.5) m; where windows face +Z (config.hips) an angle in [-0.3, 0.3) alone,
/// and a mirror image every other time where config.training.mirror is set.
Augmentation draw_augmentation(const Config& config, std::mt19937_64& random);

/// N points of a cloud `pool` (M, 3) at random among those within `radius` of `center` (3): without repetition where
/// there are enough, else each at least once. Throws Error when none is near.
torch::Tensor points_near(const torch::Tensor& pool, const torch::Tensor& center, double radius, int64_t count,
                          uint64_t seed);

/// Indices of windows, by what the clips are.
struct WindowKinds {
  std::vector<int64_t> recorded;   ///< of clips whose DatasetClip::source names a recording
  std::vector<int64_t> generated;  ///< of all others
};

/// Windows of clips in rooms, read from native data sets as they are asked for; clips and scenes are kept only while
/// recently used. Safe to use from several threads.
class Data {
 public:
  /// Windows of past + future frames, one every `stride` frames, of every clip of `split` ("train", "val", "test" or
  /// "all").
  Data(const std::vector<std::string>& folders, const std::string& split, const Config& config, int64_t stride);
  ~Data();
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;

  const WindowSet& windows() const;  ///< where they are
  const WindowKinds& kinds() const;  ///< which are of recordings
  /// Number of windows.
  int64_t size() const { return windows().size(); }
  /// Window `index`, as it is or augmented. Points and augmentation are drawn from (seed, index). @param pace how much
  /// faster than recorded (paced_window)
  Sample sample(int64_t index, uint64_t seed, bool augment, double pace = 1) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::forecast
