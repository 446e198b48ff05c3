#pragma once
#include <torch/types.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "inhabit/interact/config.h"
#include "inhabit/interact/features.h"
#include "inhabit/interact/recording.h"
#include "inhabit/nn/feature_scale.h"

namespace inhabit::interact {

/// Rows for PoseNet.
struct PoseRows {
  torch::Tensor input;   ///< (B, 4344)
  torch::Tensor target;  ///< (B, 536)
  /// (B, 8) for the left hand, then the right: its contact in the axes of the root, then 1; zeros without one.
  torch::Tensor contacts;
};

/// Sequences for ControlNet, frame by frame. Hands: right, then left, as in the control signal.
struct ControlSequences {
  torch::Tensor pose;      ///< (T, B, 66)
  torch::Tensor control;   ///< (T, B, 56) with the straight line from where the hand was
  torch::Tensor target;    ///< (T, B, 56)
  torch::Tensor wanted;    ///< (T, B, 2) 1 where the hand has a contact
  torch::Tensor rotation;  ///< (T, B, 2) cosine and sine of the rotation from the frame before's axes to the frame's
  torch::Tensor again;     ///< (T, B, 2) 1 where the contact is the frame before's, so that its plan can go on
};

/// Contacts for ContactNet.
struct ContactRows {
  torch::Tensor chair;     ///< (B, 2048)
  torch::Tensor contacts;  ///< (B, 6)
};

/// The clips of native data sets in rooms with a chair, as recordings with the one that is used (or else the first);
/// all in memory, a kilobyte a frame. Inputs are built when they are asked for. Safe to use from several threads.
class Data {
 public:
  /// @param split "train", "val", "test" or "all"; @param with_mirrored each clip's mirror image too. Clips of
  /// rooms without a chair are left out. Throws Error where a data set cannot be read, has another rate or skeleton, or
  /// a clip no rotations.
  Data(const std::vector<std::string>& folders, const std::string& split, const Config& config, bool with_mirrored);
  ~Data();
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;

  int64_t clips() const;                           ///< how many there are, mirror images too
  const Recording& recording(int64_t clip) const;  ///< one of them
  Senses senses(int64_t clip) const;               ///< of its room; valid as long as this

  const Config& config() const;  ///< what inputs are built by

  int64_t poses() const;  ///< frames that are followed by another
  /// A frame of a recording.
  struct FramePlace {
    int64_t clip;   ///< number of it
    int64_t frame;  ///< of its recording
  };
  /// Which frame a sample of PoseNet's begins with, `index` from 0 to poses() - 1.
  FramePlace pose_place(int64_t index) const;
  /// The rows of such samples.
  PoseRows pose_rows(const std::vector<int64_t>& indices) const;

  /// Sequences of control_frames frames in which a hand reaches for a contact or holds it.
  int64_t sequences() const;
  /// Those of these numbers, side by side.
  ControlSequences control_sequences(const std::vector<int64_t>& indices) const;

  /// The contacts that were held at the same time.
  int64_t contact_sets() const;
  /// Those of these numbers.
  ContactRows contact_rows(const std::vector<int64_t>& indices) const;

  /// Of PoseNet's rows, over at most `rows` of them, evenly spread. Deviations are kept from becoming so small that
  /// what is rare would count for too much: 0.01 at least; 0.1 of goals, occupancies and hands; 1 of what never
  /// changes.
  std::pair<FeatureScale, FeatureScale> scales(int64_t rows = 4000) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// At most `count` of `size` indices, evenly spread.
std::vector<int64_t> spread_indices(int64_t size, int64_t count);

}  // namespace inhabit::interact
