// Contrast, names, errors, speed and weight of pages of the bundled files: viewer/test/quality_test.mjs.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "cli/command.h"
#include "in_browser.h"

namespace inhabit {
namespace {

TEST(PageInBrowser, IsFitForEverybody) {
  TempFolder folder;
  const std::string data = INHABIT_SOURCE_DIR "/examples/data/";
  std::ofstream(folder / "m.log.jsonl")
      << "{\"stage\":\"motion\",\"step\":20,\"seconds\":1,\"rate\":0.001,\"losses\":{\"total\":2,\"path\":1}}\n"
         "{\"stage\":\"motion\",\"step\":40,\"seconds\":2,\"rate\":0.001,\"losses\":{\"total\":1,\"path\":0.4}}\n";
  std::ofstream(folder / "table.json") << R"([{"data":"all","method":"held","error":{"0.5s":1,"1.0s":2},"seam":3},
             {"data":"some","method":"held","error":{"0.5s":1,"1.0s":2},"seam":-3}])";
  const std::string sit = data + "sit.npz --scene " + data + "sit_room.glb";
  for (const std::string& arguments :
       {"view " + sit + " -o " + (folder / "sit.html") + " --note 'A person sits down.'",
        "view " + data + "walk.npz " + data + "sit.npz --scene " + data + "sit_room.glb -o " + (folder / "two.html"),
        "view -o " + (folder / "empty.html"), "view " + data + " -o " + (folder / "gallery.html"),
        "view " + (folder / "m.log.jsonl") + " " + (folder / "table.json") + " -o " + (folder / "curves.html"),
        "forecast " + data + "sit.npz --scene " + data + "sit_room.glb --start 205 -o " + (folder / "forecast.html")}) {
    const CommandResult result = run_command(arguments);
    ASSERT_EQ(result.exit_code, 0) << arguments << "\n" << result.err;
  }
  std::string said;
  const int status = in_browser("quality_test.mjs", folder, said);
  if (status == kNoBrowser) GTEST_SKIP() << said;
  EXPECT_EQ(status, 0) << said;
  std::printf("%s", said.c_str());
}

}  // namespace
}  // namespace inhabit
