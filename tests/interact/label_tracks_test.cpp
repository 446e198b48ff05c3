// Protects the strips that a page shows of a clip's labels, in numbers and in a real browser's page.
#include "inhabit/interact/label_tracks.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "cli/command.h"
#include "in_browser.h"
#include "inhabit/interact/labels.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/synth/chairs.h"

namespace inhabit::interact {
namespace {

/// Stands two seconds with the right hand moving to a place in the second one, where it stays for a second.
Clip reaching() {
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.joints = clip.skeleton.offsets.view({1, kStandardJoints, 3}).repeat({90, 1, 1});
  for (int64_t t = 30; t < 90; ++t)
    clip.joints[t][21][2] += 0.3 * std::min<double>(1, static_cast<double>(t - 30) / 30);
  clip.contact = torch::zeros({90, kStandardJoints});
  clip.hand_targets = torch::zeros({90, 2, 4});
  clip.hand_targets.slice(0, 60).select(1, 1).copy_(torch::tensor({0.25F, 0.5F, -0.25F, 1.0F}).expand({30, 4}));
  return clip;
}

TEST(LabelTracks, AReachAndWhatItIsFor) {
  const std::vector<PageTrack> tracks = label_tracks(reaching());
  ASSERT_EQ(tracks.size(), 6U);
  EXPECT_EQ(tracks[0].values.max().item<float>(), 0);
  const torch::Tensor phase = tracks[1].values.contiguous();
  EXPECT_EQ(phase[10].item<float>(), 0);
  EXPECT_NEAR(phase[45].item<float>(), 0.5, 0.15);
  EXPECT_EQ(phase[60].item<float>(), 1);
  EXPECT_EQ(phase[89].item<float>(), 1);
  EXPECT_EQ(tracks[3].labels[70].item<int64_t>(), 0);  // idle
  ASSERT_EQ(tracks[5].names, std::vector<std::string>{"0.25 0.50 -0.25"});
  EXPECT_EQ(tracks[5].labels[10].item<int64_t>(), -1);
  EXPECT_EQ(tracks[5].labels[50].item<int64_t>(), 0);  // reached for
  EXPECT_TRUE(tracks[4].names.empty());
}

TEST(LabelTracks, ClipsWithoutContactsHaveNone) {
  Clip clip = reaching();
  clip.hand_targets.zero_();
  EXPECT_TRUE(label_tracks(clip).empty());
  clip.contact = torch::Tensor();
  EXPECT_TRUE(label_tracks(clip).empty());
}

/// Somebody who sits down on a chair with both hands at it, and the same as `inhabit view` shows it in headless
/// Chromium: viewer/test/tracks_test.mjs, which exits with 77 where there is none.
TEST(LabelTracksInBrowser, ViewShowsThem) {
  std::mt19937_64 random(4);
  Room room;
  room.size = {13, 13};
  room.furniture.push_back(make_chair(random, 0.44));
  const ChairSubject subject = draw_subject(builtin_body(), random);
  const ChairTake take{Interaction::both_hands, 13, 0.4, 2};
  const auto clip = sit_on_chair(room, free_space(room), builtin_body(), subject, take, random);
  ASSERT_TRUE(clip);
  const TempFolder folder;
  write_clip_npz(folder / "sit.npz", *clip);
  const CommandResult shown = run_command("view " + (folder / "sit.npz") + " -o " + (folder / "sit.html"));
  ASSERT_EQ(shown.exit_code, 0) << shown.err;
  const Labels labels = label(*clip, Chair{});
  const torch::Tensor held = labels.hand_phase.select(1, 0).ge(0.999).nonzero();
  ASSERT_GT(held.size(0), 0);
  std::ofstream(folder / "expected.json")
      << "{\"held\": " << static_cast<double>(held[0][0].item<int64_t>()) / clip->rate
      << ", \"seconds\": " << clip->seconds() << "}";
  std::string said;
  const int status = in_browser("tracks_test.mjs", folder, said);
  if (status == kNoBrowser) GTEST_SKIP() << said;
  EXPECT_EQ(status, 0) << said;
}

}  // namespace
}  // namespace inhabit::interact
