#include "inhabit/view/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "cli/refusal.h"
#include "in_browser.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/scene/contact_map.h"
#include "inhabit/scene/sampling.h"
#include "inhabit/synth/room.h"
#include "refusal_of.h"
#include "temp_folder.h"
#include "view/striding.h"

namespace inhabit {
namespace {

/// A second observed and two seconds predicted in a furnished room, with true motion beside it and contact maps.
struct Forecast {
  Scene scene;
  Page page;

  Forecast() {
    std::mt19937_64 random(7);
    scene = make_room(random).scene();
    page.title = "Forecast in a room";
    page.note = "One second observed, two seconds predicted.";
    page.scene = &scene;
    page.people = {{striding(30, 0, -1), "Observed", PagePerson::Role::past, 0.0, nullptr},
                   {striding(60, 0, -1, 30), "Truth", PagePerson::Role::truth, 1.0, nullptr},
                   {striding(60, 0.5, -1, 30), "Prediction", PagePerson::Role::prediction, 1.0, nullptr}};
    Clip& past = page.people[0].clip;
    past.action_names = {"walk", "turn"};
    past.action = (torch::arange(30) > 14).to(torch::kInt64);
    past.hand_targets = torch::zeros({30, 2, 4});
    past.hand_targets.index_put_({torch::indexing::Slice(), 0}, torch::tensor({0.3F, 1.0F, -0.5F, 1.0F}));
    const torch::Tensor joints = torch::cat({past.joints, page.people[1].clip.joints});
    PageContacts contacts;
    contacts.points = sample_points_near(scene, past.joints[29][0], 2.5, 5000, random);
    contacts.maps = contact_map(joints, contacts.points);
    page.contacts = contacts;
  }
};

std::string text_of(const std::string& path) { return read_whole_file(path); }

TEST(Page, ThreeSecondsInARoomWithContactsStayBelowFourMegabytes) {
  TempFolder folder;
  const Forecast forecast;
  write_page(folder / "page.html", forecast.page);
  const auto bytes = std::filesystem::file_size(folder / "page.html");
  RecordProperty("bytes", static_cast<int>(bytes));
  EXPECT_LT(bytes, 4'000'000U);
  EXPECT_GT(bytes, 500'000U);
}

TEST(Page, NamesNothingOutsideItself) {
  TempFolder folder;
  write_page(folder / "page.html", Forecast().page);
  const std::string text = text_of(folder / "page.html");
  for (const char* reference : {" src=\"", "src='", "href=\"http", "@import", "url(http"}) {
    EXPECT_EQ(text.find(reference), std::string::npos) << reference;
  }
}

TEST(Page, TextIsNeverMarkup) {
  TempFolder folder;
  Page page;
  const std::string evil =
      "</script></title><script>window.hacked=1</script><!--inhabit:data--><img id=evil onerror=1>\xff";
  page.title = page.note = evil;
  page.people = {{striding(3, 0, 0), evil, PagePerson::Role::motion, 0.0, nullptr}};
  write_page(folder / "page.html", page);
  const std::string text = text_of(folder / "page.html");
  EXPECT_EQ(text.find("<script>window.hacked"), std::string::npos);
  EXPECT_EQ(text.find("<img"), std::string::npos);
  EXPECT_NE(text.find("&lt;script&gt;window.hacked=1"), std::string::npos);
  EXPECT_NE(text.find("\\u003cscript>window.hacked=1"), std::string::npos);
}

TEST(Page, RefusesWhatIsNotFiniteAndKeepsTheOldFile) {
  TempFolder folder;
  const std::string path = folder / "page.html";
  std::ofstream(path) << "old";
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Forecast forecast;
  const auto refused = [&](const char* word) {
    EXPECT_THAT(refusal_of([&] { write_page(path, forecast.page); }), testing::HasSubstr(word));
    EXPECT_EQ(text_of(path), "old");
    forecast = Forecast();
    forecast.page.scene = &forecast.scene;
  };
  forecast.page.scene = &forecast.scene;
  forecast.page.people[1].clip.joints[3][4][1] = nan;
  refused("finite");
  forecast.page.people[1].clip.rotations[3][4][1] = nan;
  refused("finite");
  forecast.page.people[0].start_seconds = std::numeric_limits<double>::infinity();
  refused("start");
  forecast.scene.meshes[0].vertices[0][0] = nan;
  refused("mesh");
  forecast.scene.meshes[0].faces[0][0] = 1 << 30;
  refused("vertex");
  forecast.scene.points = torch::full({4, 3}, nan);
  refused("cloud");
  forecast.page.contacts->maps[2][3][4] = nan;
  refused("contact map");
  forecast.page.contacts->points = torch::zeros({7, 3});
  refused("do not agree");
  forecast.page.contacts->rate = 0;
  refused("rate");
  forecast.page.contacts->names = {"one"};
  refused("names");
  forecast.page.people[1].keys = {60};
  refused("key frame");
  forecast.page.people[1].collides = torch::zeros({59}, torch::kBool);
  refused("collisions");
  forecast.page.people[1].tracks = {{"phase", torch::zeros({59})}};
  refused("track phase");
  forecast.page.people[1].tracks = {{"action", {}, torch::ones({60}, torch::kInt64), {"idle"}}};
  refused("without a name");
  forecast.page.people.clear();
  forecast.page.scene = nullptr;
  refused("nothing to show");
}

TEST(Page, UnwritableFolderIsAnError) {
  Forecast forecast;
  EXPECT_THROW(write_page("/nowhere/at/all/page.html", forecast.page), Error);
}

TEST(Page, ThinsALargeScene) {
  TempFolder folder;
  const int64_t side = 700;  // 2 x 699^2 = 977,202 triangles
  const torch::Tensor line = torch::linspace(-5, 5, side);
  const torch::Tensor x = line.unsqueeze(1).expand({side, side}), z = line.unsqueeze(0).expand({side, side});
  Mesh mesh;
  mesh.name = "scan";
  mesh.vertices = torch::stack({x, 0.05 * torch::sin(x * 3), z}, 2).reshape({-1, 3});
  const torch::Tensor index = torch::arange(side * side).reshape({side, side});
  const auto corner = [&](int64_t i, int64_t j) {
    return index.slice(0, i, side - 1 + i).slice(1, j, side - 1 + j).reshape({-1});
  };
  mesh.faces = torch::cat({torch::stack({corner(0, 0), corner(0, 1), corner(1, 1)}, 1),
                           torch::stack({corner(0, 0), corner(1, 1), corner(1, 0)}, 1)});
  Scene scene;
  scene.meshes.push_back(mesh);
  scene.points = torch::rand({300'000, 3});
  Page page;
  page.people = {{striding(90, 0, 0), "", PagePerson::Role::motion, 0.0, nullptr}};
  page.scene = &scene;
  write_page(folder / "page.html", page);
  EXPECT_LT(std::filesystem::file_size(folder / "page.html"), 4'000'000U);
}

// What a visitor sees: viewer/test/page_test.mjs opens the pages in headless Chromium. It skips (exit code 77) where
// there is no Chromium.
TEST(PageInBrowser, ShowsMovesAndPaints) {
  TempFolder folder;
  const Forecast forecast;
  write_page(folder / "forecast.html", forecast.page);

  Page hostile;
  const std::string evil = "</script><script>window.hacked=1</script><img src=x onerror=window.hacked=1>";
  hostile.title = hostile.note = evil;
  Clip clip = striding(30, 0, 0);
  clip.action_names = {evil};
  clip.action = torch::zeros({30}, torch::kInt64);
  hostile.people = {{clip, evil, PagePerson::Role::motion, 0.0, nullptr}};
  Scene scene = floor_scene();
  scene.meshes[0].name = evil;
  hostile.scene = &scene;
  write_page(folder / "hostile.html", hostile);

  Page skeleton;  // joints only, of a skeleton of three joints; one frame beside fifty futures
  Clip chain;
  chain.skeleton.names = {"base", "middle", "end"};
  chain.skeleton.parents = {-1, 0, 1};
  chain.skeleton.offsets = torch::tensor({{0.0F, 0.0F, 0.0F}, {0.0F, 0.5F, 0.0F}, {0.0F, 0.5F, 0.0F}});
  chain.joints = torch::rand({1, 3, 3});
  skeleton.people.push_back({chain, "chain", PagePerson::Role::past, 0.0, nullptr});
  for (int k = 0; k < 50; ++k)
    skeleton.people.push_back({striding(60, 0.05 * k, 0), "", PagePerson::Role::prediction, 0.0, nullptr});
  write_page(folder / "crowd.html", skeleton);

  Page filled;  // between key frames, inside the scene for a third of a second
  PagePerson between{striding(60, 0, 0), "filled in", PagePerson::Role::filled};
  between.keys = {0, 20, 59};
  between.collides = torch::zeros({60}, torch::kBool);
  between.collides.slice(0, 30, 40).fill_(true);
  between.collides_with = {"66 mm in table_0"};
  filled.people.push_back(between);
  write_page(folder / "filled.html", filled);
  // The middle key gave a wrist 10 cm above where it came out, and nothing else.
  PagePerson& partial = filled.people.front();
  partial.given = frames_at(partial.clip, partial.keys);
  partial.given->joints[1][20][1] += 0.1;
  partial.given_joints = {20};
  partial.collides.slice(0, 55, 60).fill_(true);  // the last key too
  write_page(folder / "partial.html", filled);

  // Where the joints have to be drawn, from this side's kinematics.
  nlohmann::json expected;
  const auto numbers = [](const torch::Tensor& place) {
    return nlohmann::json{place[0].item<float>(), place[1].item<float>(), place[2].item<float>()};
  };
  const torch::Tensor joints = forecast.page.people[2].clip.joints[15].contiguous();  // 1.5 s
  for (int64_t j = 0; j < joints.size(0); ++j) expected["joints"].push_back(numbers(joints[j]));
  expected["wrist"] = numbers(partial.given->joints[1][20]);
  std::ofstream(folder / "expected.json") << expected.dump();

  std::string said;
  const int status = in_browser("page_test.mjs", folder, said);
  if (status == kNoBrowser) GTEST_SKIP() << said;
  EXPECT_EQ(status, 0) << said;
}

TEST(ViewCommand, ShowsAMotionInAScene) {
  TempFolder folder;
  write_clip(folder / "walk.npz", striding(30, 0, 0));
  write_scene(folder / "floor.glb", floor_scene());
  const CommandResult result = run_command("view " + (folder / "walk.npz") + " --scene " + (folder / "floor.glb") +
                                           " -o " + (folder / "page.html") + " --title 'A < B'");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string text = text_of(folder / "page.html");
  EXPECT_NE(text.find("<title>A &lt; B</title>"), std::string::npos);
  EXPECT_NE(text.find("\"name\":\"walk\""), std::string::npos);
  EXPECT_NE(text.find("\"rotations\":"), std::string::npos);
  EXPECT_NE(text.find("\"meshes\":[{"), std::string::npos);
}

TEST(ViewCommand, ReadsMotionsAsItIsTold) {
  TempFolder folder;
  write_clip(folder / "walk.npz", striding(30, 0, 0));
  write_clip(folder / "long.npz", striding(90, 0, 0));
  const std::string page = folder / "page.HTML";
  const CommandResult r =
      run_command("view " + (folder / "walk.npz") + " " + (folder / "long.npz") + " --input-rate 15 -o " + page);
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("2 motions, 6.0 s"), std::string::npos) << r.out;  // the longer
  std::filesystem::create_directory(folder / "out");
  expect_refused("view " + (folder / "walk.npz") + " -o " + (folder / "out/page.txt"), {"page.txt", ".html"},
                 folder / "out");
}

TEST(ViewCommand, NamesTheFileThatIsMissing) {
  TempFolder folder;
  const CommandResult result = run_command("view " + (folder / "none.npz") + " -o " + (folder / "page.html"));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("none.npz"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "page.html"));
}

}  // namespace
}  // namespace inhabit
