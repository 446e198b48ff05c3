// Protects the tables of interaction: recordings meet their own contacts and sit on their own seats, somebody who
// stands still does neither, and the numbers are those of closed forms.
#include "inhabit/interact/evaluate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "inhabit/synth/chairs.h"
#include "interact/sitter_data.h"
#include "temp_folder.h"

namespace inhabit::interact {
namespace {

TEST(EvaluateInteract, RecordingsMeetTheirContactsAndWhoStandsStillDoesNot) {
  const TempFolder folder;
  const std::string data = write_sitters(folder / "sitters");
  const std::vector<Trial> trials = trials_of({data}, "test", 10, 60);
  ASSERT_EQ(trials.size(), 1);
  const Trial& trial = trials.front();
  int64_t contacts = 0;
  for (const auto& contact : trial.contacts) contacts += contact ? 1 : 0;
  ASSERT_GT(contacts, 0);
  EXPECT_EQ(trial.start.frames(), 1);
  const InteractMethod still{"still", [](const Trial& t, uint64_t) {
                               Clip clip = frames_at(t.start, std::vector<int64_t>(60, 0));
                               clip.action_names = {"idle", "walk", "sit"};
                               clip.action = torch::zeros({60}, torch::kInt64);
                               return clip;
                             }};
  const Table table = evaluate(trials, {still}, 1);
  ASSERT_EQ(table.rows.size(), 2);
  EXPECT_EQ(table.contacts, contacts);
  const Scores &recorded = table.rows[0], &standing = table.rows[1];
  EXPECT_EQ(recorded.method, "data");
  EXPECT_LT(recorded.contact_error.mean, 0.12) << "the wrist is there, the palm 9 cm farther";
  EXPECT_GT(standing.contact_error.mean, 0.2);
  EXPECT_EQ(standing.precision[3].mean, 0);
  EXPECT_EQ(standing.success.mean, 0);
  EXPECT_EQ(standing.jerk, 0);
  EXPECT_GT(recorded.apd_sit, 0);
  EXPECT_TRUE(std::isnan(standing.apd_sit)) << "nobody sits";
  const std::string text = table_text(table);
  EXPECT_NE(text.find("still"), std::string::npos);
  EXPECT_EQ(table_json(table)["rows"].size(), 2);
}

// A table of 120 runs is of 120 people who sit, though some clips show people who only walk.
TEST(EvaluateInteract, ClipsInWhichNobodySitsGiveTheirPlaceToTheNext) {
  const TempFolder folder;
  ChairsOptions options;
  options.minutes = 30;
  const Dataset made = generate_chairs(folder / "chairs", options);
  std::vector<std::string> seated;
  bool walked = false;  // by people who do not sit, before others who do
  for (const DatasetClip& entry : made.split("train")) {
    const bool sits = parse_chair_source(entry.source).interaction != Interaction::locomotion;
    if (sits) seated.push_back(folder / "chairs/" + entry.file);
    walked = walked || (!sits && seated.size() < 20);
  }
  ASSERT_TRUE(walked);
  const std::vector<Trial> trials = trials_of({folder / "chairs"}, "train", 20, 16);
  EXPECT_EQ(trials.size(), 20);
  std::set<std::string> names;
  for (const Trial& trial : trials) {
    names.insert(trial.name);
    EXPECT_NE(std::find(seated.begin(), seated.end(), trial.name), seated.end()) << trial.name;
  }
  EXPECT_EQ(names.size(), 20) << "each once";
}

}  // namespace
}  // namespace inhabit::interact
