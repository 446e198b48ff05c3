// Protects how the motions of files become people of one page: their names, who is a small figure, and the title.
#include "inhabit/view/file_people.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/io/files.h"
#include "inhabit/view/file_cards.h"
#include "temp_folder.h"
#include "view/striding.h"

namespace inhabit {
namespace {

using testing::ElementsAre;

std::vector<std::string> person_names(const std::vector<PagePerson>& people) {
  std::vector<std::string> out;
  for (const PagePerson& person : people) out.push_back(person.name);
  return out;
}

TEST(FilePeople, AreCalledAfterTheirFilesAndNumberedWhereTheseHoldSeveral) {
  const TempFolder folder;
  write_clip(folder / "walk.npz", striding(60, 0, 0));
  write_clips(folder / "two.npz", {striding(90, 0, 0), striding(90, 1, 0)});
  write_clips(folder / "many.npz", std::vector<Clip>(5, striding(30, 0, 0)));
  Notes notes;
  const auto people = people_of_files({folder / "walk.npz", folder / "two.npz"}, {}, notes);
  EXPECT_THAT(person_names(people), ElementsAre("walk", "two 0", "two 1"));
  EXPECT_NEAR(longest_seconds(people), 3, 1e-9);
  for (const PagePerson& person : people) EXPECT_EQ(person.role, PagePerson::Role::motion);
  const auto crowd = people_of_files({folder / "many.npz"}, {}, notes);
  ASSERT_EQ(crowd.size(), 5U);
  for (const PagePerson& person : crowd) EXPECT_EQ(person.role, PagePerson::Role::future);
  EXPECT_EQ(longest_seconds({}), 0);
}

TEST(FilePeople, GiveThePageItsTitle) {
  EXPECT_EQ(title_of_files({"in/walk.bvh", "sit.npz"}, "room.glb"), "walk");
  EXPECT_EQ(title_of_files({}, "in/room.glb"), "room");
  EXPECT_EQ(title_of_files({}, ""), "");
  EXPECT_EQ(cards_title({"in/walk.bvh"}), "walk.bvh");
  EXPECT_EQ(cards_title({"recordings/", "a", "b"}), "recordings and 2 more");
}

}  // namespace
}  // namespace inhabit
