// Protects the JSON of scores: where horizons lie, and by which name each kind is known.
#include "inhabit/metrics/score_json.h"

#include <gtest/gtest.h>

namespace inhabit {
namespace {

TEST(ScoreJson, HorizonsAreFramesAfterTheStart) {
  const torch::Tensor by_frame = torch::arange(1, 51);  // two seconds at 25 frames a second, the first frame 1/25 s on
  EXPECT_EQ(at_horizons(by_frame, 25, 10).dump(), R"([{"seconds":0.4,"value":100.0},{"seconds":0.8,"value":200.0},)"
                                                  R"({"seconds":1.6,"value":400.0},{"seconds":2.0,"value":500.0}])");
  EXPECT_EQ(at_horizons(by_frame.slice(0, 0, 5), 25).dump(), "[]") << "none is reached";
}

TEST(ScoreJson, BeginsWithTheNameOfItsKind) {
  EXPECT_EQ(begin_scores(ScoreKind::fid, 2).dump(), R"({"fid":2.0})");
  EXPECT_EQ(begin_scores(ScoreKind::error, 0.5).dump(), R"({"world_error_mm":0.5})");
  EXPECT_STREQ(kScoreNames[static_cast<size_t>(ScoreKind::skating)], "foot_skating");
  EXPECT_EQ(score_json(SkatingScore(), {}).begin().key(), "foot_skating");
  EXPECT_EQ(score_json(JerkScore(), {}).begin().key(), "jerk");
  EXPECT_EQ(score_json(PenetrationScore(), {}).begin().key(), "collision_frame_ratio");
  EXPECT_EQ(score_json(NdmsScore(), {}).begin().key(), "ndms");
}

}  // namespace
}  // namespace inhabit
