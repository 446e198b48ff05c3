// Protects which files become cards, what a card says of its file, and what is left out of a folder and said.
#include "inhabit/view/file_cards.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "forecast/walker_data.h"
#include "inhabit/io/files.h"
#include "refusal_of.h"
#include "temp_folder.h"
#include "view/striding.h"

namespace inhabit {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

void write_text(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

std::vector<std::string> card_names(const std::vector<PageCard>& cards) {
  std::vector<std::string> out;
  for (const PageCard& card : cards) out.push_back(card.name);
  return out;
}

TEST(FileCards, AreOfFoldersLogsAndTables) {
  const TempFolder folder;
  write_text(folder / "table.json", R"({"rows": [{"method": "held", "error": 1}]})");
  write_clip(folder / "motion.json", striding(5, 0, 0));
  EXPECT_TRUE(is_shown_as_cards(folder.path.string()));
  EXPECT_TRUE(is_shown_as_cards("m.log.jsonl"));
  EXPECT_TRUE(is_shown_as_cards(folder / "table.json"));
  EXPECT_FALSE(is_shown_as_cards(folder / "motion.json"));
  EXPECT_FALSE(is_shown_as_cards(folder / "missing.json"));
  EXPECT_FALSE(is_shown_as_cards("walk.bvh"));
}

TEST(FileCards, ShowAtMostAMinuteOfAMotionFifteenTimesASecond) {
  const TempFolder folder;
  write_clip(folder / "short.npz", striding(60, 1, 2));
  write_clip(folder / "long.npz", striding(1950, 0, 0));
  Notes notes;
  std::vector<std::string> skipped;
  const std::vector<PageCard> cards = cards_of({folder / "short.npz", folder / "long.npz"}, {}, notes, skipped);
  ASSERT_THAT(card_names(cards), ElementsAre("short.npz", "long.npz"));
  EXPECT_EQ(cards[0].note, "2.0 s, 30 frames a second, 22 joints");
  ASSERT_TRUE(cards[0].person.has_value());
  EXPECT_EQ(cards[0].person->clip.rate, 15);
  const torch::Tensor whole = read_clip(folder / "short.npz").joints;
  EXPECT_TRUE(cards[0].person->clip.joints.allclose(whole.slice(0, 0, 60, 2), 0, 1e-4));
  EXPECT_EQ(cards[1].note, "65.0 s, 30 frames a second, 22 joints; the first 60 s");
  EXPECT_EQ(cards[1].person->clip.frames(), 900);
}

TEST(FileCards, OfAFolderLeaveOutWhatCannotBeReadAndSayIt) {
  const TempFolder folder;
  const std::string in = folder / "in";
  std::filesystem::create_directories(in + "/a");
  write_clip(in + "/a/far.npz", striding(30, 0, 0));
  write_clips(in + "/several.npz", {striding(30, 0, 0), striding(30, 1, 0)});
  write_scene(in + "/room.glb", floor_scene());
  write_text(in + "/broken.bvh", "HIERARCHY");
  write_text(in + "/readme.md", "not looked at");
  write_text(in + "/notes.txt", "nothing to be shown");
  Notes notes;
  std::vector<std::string> skipped;
  const std::vector<PageCard> cards = cards_of({in}, {}, notes, skipped);
  ASSERT_THAT(card_names(cards), ElementsAre("a/far.npz", "room.glb", "several.npz"));
  EXPECT_EQ(cards[1].note, "1 mesh, 2 triangles");
  EXPECT_NE(cards[1].scene, nullptr);
  EXPECT_THAT(cards[2].note, HasSubstr(", the first of 2"));
  ASSERT_EQ(skipped.size(), 1U);
  EXPECT_THAT(skipped[0], StartsWith(in + "/broken.bvh: "));
  EXPECT_THAT(notes, testing::ElementsAre(HasSubstr("1 .txt and .json files that show nothing")));

  std::filesystem::create_directories(folder / "bad");
  write_text(folder / "bad/one.bvh", "HIERARCHY");
  EXPECT_THAT(
      refusal_of([&] { cards_of({folder / "bad"}, {}, notes, skipped); }),
      testing::AllOf(HasSubstr("bad: holds nothing that can be shown (1 tried; skipped "), HasSubstr("one.bvh")));
  EXPECT_THAT(refusal_of([&] { cards_of({in + "/readme.md"}, {}, notes, skipped); }), HasSubstr("readme.md"))
      << "a file that is named is not passed over";
}

TEST(FileCards, OfANativeDataSetAreItsClipsInTheirScenes) {
  const TempFolder folder;
  Notes notes;
  std::vector<std::string> skipped;
  const std::vector<PageCard> cards = cards_of({write_walkers(folder / "walkers")}, {}, notes, skipped);
  EXPECT_THAT(card_names(cards), ElementsAre("clips/0.npz", "clips/1.npz", "clips/2.npz", "clips/3.npz"));
  EXPECT_EQ(cards[1].note, "4.0 s, 30 frames a second, 22 joints, in scenes/val.glb");
  EXPECT_NE(cards[1].scene, nullptr);
  EXPECT_EQ(cards[3].note, "4.0 s, 30 frames a second, 22 joints");
  EXPECT_EQ(cards[3].scene, nullptr);
  EXPECT_THAT(notes, IsEmpty());
}

TEST(ReadForView, PutsTheFilesNameBeforeItsNotes) {
  const TempFolder folder;
  const std::string path = folder / "far.bvh";
  write_clip(path, striding(30, 0, 0));
  ClipReadOptions reading;
  reading.scale = 1;  // metres, where the file is in centimetres: a person of 170 m
  Notes notes;
  const std::vector<Clip> clips = read_for_view(path, reading, notes);
  ASSERT_EQ(clips.size(), 1U);
  EXPECT_EQ(clips[0].skeleton.names, standard_joint_names());
  ASSERT_FALSE(notes.empty());
  for (const std::string& note : notes) EXPECT_THAT(note, StartsWith(path + ": "));
}

}  // namespace
}  // namespace inhabit
