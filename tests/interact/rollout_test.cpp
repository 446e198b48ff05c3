// Protects rollouts: a network that is right stays on the recording, and the target of a frame leads from wherever the
// person has got to, back to the recording.
#include "inhabit/interact/rollout.h"

#include <gtest/gtest.h>

#include "interact/sitter_data.h"
#include "largest.h"
#include "temp_folder.h"

namespace inhabit::interact {
namespace {

class Rollout : public testing::Test {
 protected:
  TempFolder folder_;
  Config config_ = preset("compact");
  Data data_{{write_sitters(folder_ / "sitters")}, "train", config_, false};
  int64_t frame_ = 20;  // walking

  /// What is right for the frames that follow: recorded targets, one after the other.
  PoseFunction right(double off = 0) {
    return [this, off, t = int64_t{0}](const torch::Tensor&, const torch::Tensor&) mutable {
      torch::Tensor y = data_.pose_rows({frame_ + t++}).target;
      y.slice(1, 0, 264).view({-1, 22, 12}).slice(2, 0, 1).add_(off);
      return y;
    };
  }
};

TEST_F(Rollout, ARightNetworkStaysOnTheRecording) {
  const PoseRows rows = rollout(data_, {frame_}, 6, right());
  ASSERT_EQ(rows.input.size(0), 6);
  for (int64_t t = 0; t < 6; ++t) {
    const PoseRows recorded = data_.pose_rows({frame_ + t});
    EXPECT_LT(largest(rows.input[t].slice(0, 0, 264) - recorded.input[0].slice(0, 0, 264)), 0.02) << t;
    EXPECT_LT(largest(rows.target[t].slice(0, 0, 264) - recorded.target[0].slice(0, 0, 264)), 0.02) << t;
  }
}

TEST_F(Rollout, TargetsLeadBackToTheRecording) {
  // The pose is put 4 cm aside each frame, and half of that is taken (positions are a mean): targets must be aside by
  // as much to the other side, as seen from where the person is.
  const PoseRows rows = rollout(data_, {frame_}, 4, right(0.04));
  const PoseRows recorded = data_.pose_rows({frame_ + 3});
  const auto wrist = [](const torch::Tensor& row) { return row.slice(0, 21 * 12, 21 * 12 + 3); };
  EXPECT_GT(largest(wrist(rows.input[3]) - wrist(recorded.input[0])), 0.01) << "the person is aside";
  EXPECT_LT(largest(wrist(rows.target[3]) - wrist(recorded.target[0])), 0.01) << "where to go is not";
}

TEST_F(Rollout, SeveralPeopleAreEachTheirOwn) {
  const auto still = [](const torch::Tensor& input, const torch::Tensor&) {
    torch::Tensor y = torch::zeros({input.size(0), 536});
    y.slice(1, 0, 264).copy_(input.slice(1, 0, 264));
    return y;
  };
  const PoseRows both = rollout(data_, {frame_, 5}, 3, still), one = rollout(data_, {5}, 3, still);
  for (int64_t t = 0; t < 3; ++t) EXPECT_LT(largest(both.input[2 * t + 1] - one.input[t]), 1e-5);
}

}  // namespace
}  // namespace inhabit::interact
