// Protects the rows that training is given.
#include "inhabit/interact/sample.h"

#include <gtest/gtest.h>

#include "interact/sitter_data.h"
#include "temp_folder.h"

namespace inhabit::interact {
namespace {

class SitterData : public testing::Test {
 protected:
  TempFolder folder;
  Config config = preset("paper");
  std::string path = write_sitters(folder / "sitters");
};

TEST_F(SitterData, RowsAreWhatTheFeaturesSay) {
  const Data data({path}, "train", config, true);
  ASSERT_EQ(data.clips(), 2);  // and its mirror image
  // The clip ends in a walk: its last second has no future.
  EXPECT_EQ(data.poses(), 2 * (239 - 30));
  const PoseRows rows = data.pose_rows({100, 209 + 100});
  std::vector<float> x(4344), y(536);
  const State now = state_at(data.recording(0), 100);
  build_input(input_layout(config), now, data.senses(0), x.data());
  build_target(output_layout(config), now, state_at(data.recording(0), 101), y.data());
  EXPECT_TRUE(torch::equal(rows.input[0], torch::tensor(x)));
  EXPECT_TRUE(torch::equal(rows.target[0], torch::tensor(y)));
  EXPECT_FALSE(torch::equal(rows.input[0], rows.input[1]));
  EXPECT_TRUE(torch::isfinite(rows.input).all().item<bool>());
  // The left hand's contact, and in the mirror the right one's.
  EXPECT_EQ(rows.contacts[0][3].item<float>(), 1);
  EXPECT_EQ(rows.contacts[0][7].item<float>(), 0);
  EXPECT_EQ(rows.contacts[1][7].item<float>(), 1);
  EXPECT_NEAR(rows.contacts[0][0].item<float>(), -rows.contacts[1][4].item<float>(), 1e-5);
}

TEST_F(SitterData, SequencesGoFromFrameToFrame) {
  const Data data({path}, "train", config, false);
  ASSERT_GT(data.sequences(), 0);
  const ControlSequences s = data.control_sequences({0});
  ASSERT_EQ(s.pose.size(0), 60);
  EXPECT_EQ(s.wanted[0][0][1].item<float>(), 1);  // begins where the left hand leaves
  EXPECT_EQ(s.again[0][0][1].item<float>(), 0);
  EXPECT_EQ(s.again[1][0][1].item<float>(), 1);
  // The target's first point is the next frame's hand: in its axes, where its straight line starts.
  for (int64_t t = 0; t + 1 < 40; ++t) {
    if (s.again[t + 1][0][1].item<float>() == 0) continue;
    const torch::Tensor first = s.target[t][0].slice(0, 21, 24), rotation = s.rotation[t + 1][0];
    const float c = rotation[0].item<float>(), si = rotation[1].item<float>();
    const float x = first[0].item<float>(), z = first[2].item<float>();
    EXPECT_NEAR(s.control[t + 1][0][21].item<float>(), c * x + si * z, 1e-4) << t;
    EXPECT_NEAR(s.control[t + 1][0][23].item<float>(), c * z - si * x, 1e-4) << t;
  }
}

TEST_F(SitterData, ContactsAreInTheSeatsAxes) {
  const Data data({path}, "train", config, false);
  ASSERT_EQ(data.contact_sets(), 1);
  const ContactRows rows = data.contact_rows({0});
  const Eigen::Vector3f touch = Sitter().touch;
  // The seat is where the pelvis rests, at (0, -0.05), and faces +Z.
  EXPECT_TRUE(torch::allclose(rows.contacts[0], torch::tensor({0.F, 0.F, 0.F, touch.x(), touch.y(), touch.z() + 0.05F}),
                              1e-3, 1e-3))
      << rows.contacts;
}

TEST_F(SitterData, ScalesAreThoseOfTheRowsAndNeverTooSmall) {
  const Data data({path}, "train", config, false);
  const auto [in, out] = data.scales(100);
  EXPECT_EQ(in.mean.size(0), 4344);
  EXPECT_EQ(out.mean.size(0), 536);
  EXPECT_GE(in.deviation.min().item<float>(), 0.0099F);
  EXPECT_EQ(in.deviation[0].item<float>(), 1);  // the pelvis is above the root, always
  const PoseRows rows = data.pose_rows(spread_indices(data.poses(), 100));
  EXPECT_TRUE(torch::allclose(in.mean, rows.input.mean(0), 1e-4, 1e-4));
}

}  // namespace
}  // namespace inhabit::interact
