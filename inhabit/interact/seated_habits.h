#pragma once
#include <torch/types.h>

#include <random>
#include <vector>

#include "inhabit/interact/state.h"
#include "inhabit/interact/voxels.h"

namespace inhabit::interact {

class Data;

/// What people of the training data did while they sat: where head, ankles and palms were, six times a second. A model
/// file keeps some hundred stays. PoseNet is told where these are a second ahead (State::ahead), so that seated people
/// shift, stretch their legs and gesture as those did, each in their own way.
struct SeatedHabits {
  torch::Tensor chairs;   ///< (H, 4 N^3) of each stay's chair: contact_condition
  torch::Tensor heights;  ///< (H) metres of its seat over the floor
  torch::Tensor ends;     ///< (H) int64: one past its last row of points
  /// (R, 15) head, left and right ankle, left and right palm in the axes of the seat on the floor; heights of head and
  /// palms over the seat.
  torch::Tensor points;

  /// How many stays.
  int64_t size() const { return ends.defined() ? ends.size(0) : 0; }
};

/// Of the stays of two seconds and more at most `count`, evenly spread. Empty where there are none.
SeatedHabits habits_of(const Data& data, int64_t count);

/// Somebody's habits on a chair: one stay after the other, drawn from those on the chairs that are most like theirs.
class SeatedLife {
 public:
  /// @param habits must outlive this
  SeatedLife(const SeatedHabits& habits, const ChairGrid& chair, double seat_height);
  /// Where head, ankles and palms are to be a second from now. To be called once a frame. The movement is that of the
  /// recorded person within that second, and a tenth of the distance to where the recorded person then is. It is a
  /// tenth because the networks were trained on people who are where they were recorded: told the whole distance, they
  /// do not set out at all.
  AheadPose next(const State& state, std::mt19937_64& random);

 private:
  const SeatedHabits& habits_;
  Place seat_;
  float height_;
  std::vector<int64_t> alike_;      // stays
  int64_t stay_ = -1, passed_ = 0;  // frames of it
};

}  // namespace inhabit::interact
