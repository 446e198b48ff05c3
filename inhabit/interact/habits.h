#pragma once
#include <torch/types.h>

#include <optional>
#include <random>
#include <vector>

#include "inhabit/interact/state.h"
#include "inhabit/interact/voxels.h"

namespace inhabit::interact {

class Data;

/// Where head, left and right ankle, left and right palm of recorded people were, six times a second.
struct StayPoints {
  torch::Tensor ends;    ///< (H) int64: one past each stay's last row of points
  torch::Tensor points;  ///< (R, 15)

  /// How many stays.
  int64_t size() const { return ends.defined() ? ends.size(0) : 0; }
};

/// What people of the training data did while they stayed where they were and no hand had a contact. A model file keeps
/// some hundred stays. PoseNet is told where these people are a second ahead (State::ahead), so that those who sit
/// shift, stretch their legs and gesture, and those who stand shift their weight, gesture and look about, each in their
/// own way.
struct Habits {
  torch::Tensor chairs;   ///< (H, 4 N^3) of each seated stay's chair: contact_condition
  torch::Tensor heights;  ///< (H) metres of its seat over the floor
  StayPoints seated;      ///< in the axes of the seat on the floor, metres; heights of head and palms are over the seat
  StayPoints standing;    ///< in the axes of the root where the stay began, between the ankles; 1 is the head's height
};

/// Of the stays of two seconds and more at most `seated` and at most `standing`, evenly spread. Empty where there are
/// none.
Habits habits_of(const Data& data, int64_t seated, int64_t standing);

/// Goes through stays frame by frame, one after the other, each drawn from some of them.
class StayWalk {
 public:
  /// @param stays must outlive this @param drawn the stays to draw from, one at least
  StayWalk(const StayPoints& stays, std::vector<int64_t> drawn) : stays_(stays), drawn_(std::move(drawn)) {}
  /// To the next frame, which is the first of another stay where this one has no second left. @return whether it is.
  bool advance(std::mt19937_64& random);
  /// Point k (0 head, 1 and 2 ankles, 3 and 4 palms) at this frame, or `ahead` frames on; the stay's last if it ends.
  Eigen::Vector3f point(int64_t k, int64_t ahead = 0) const;

 private:
  int64_t begin() const { return stay_ > 0 ? stays_.ends.data_ptr<int64_t>()[stay_ - 1] : 0; }
  int64_t last() const { return stays_.ends.data_ptr<int64_t>()[stay_] - 1; }

  const StayPoints& stays_;
  std::vector<int64_t> drawn_;
  int64_t stay_ = -1, passed_ = 0;  // frames of it
};

/// Somebody's habits on a chair: stays on the chairs that are most like theirs.
class SeatedLife {
 public:
  /// @param habits must outlive this
  SeatedLife(const Habits& habits, const ChairGrid& chair, double seat_height);
  /// Where head, ankles and palms are to be a second from now. To be called once a frame. The movement is that of the
  /// recorded person within that second, and a tenth of the distance to where the recorded person then is. It is a
  /// tenth because the networks were trained on people who are where they were recorded: told the whole distance, they
  /// do not set out at all.
  AheadPose next(const State& state, std::mt19937_64& random);

 private:
  StayWalk walk_;
  Place seat_;
  float height_;
};

/// Somebody's habits while they stand.
class StandingLife {
 public:
  /// @param habits must outlive this
  explicit StandingLife(const Habits& habits);
  /// As SeatedLife::next. Ankles are to be where they were at the first call: drawn to the recorded person's stance,
  /// which is another, or told the recorded movement alone, feet slide.
  AheadPose next(const State& state, std::mt19937_64& random);

 private:
  StayWalk walk_;
  Place place_;       // where the stay began
  float height_ = 1;  // metres of the head, then
  std::optional<std::array<Eigen::Vector3f, 2>> ankle_;
};

}  // namespace inhabit::interact
