// Protects what folders and patterns stand for, and that a bad file among many is skipped with its reason.
#include "inhabit/io/many_files.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/shipped_model.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using testing::ElementsAre, testing::HasSubstr;

TEST(ManyFiles, AFolderIsItsMotionAndAPatternWhatItMatches) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "in/below");
  for (const char* name : {"in/b.bvh", "in/a.bvh", "in/below/c.amc", "in/picture.png", "in/room.obj"})
    write_atomically(folder / name, "x");
  write_npy(folder / "in/cloud.npy", torch::rand({40, 3}));
  write_atomically(folder / "in/cut.npz", "PK");
  const std::string in = folder / "in";
  EXPECT_THAT(motion_files({in}), ElementsAre(in + "/a.bvh", in + "/b.bvh", in + "/below/c.amc", in + "/cut.npz"));
  EXPECT_THAT(motion_files({in + "/?.bvh", "missing.npz"}), ElementsAre(in + "/a.bvh", in + "/b.bvh", "missing.npz"));
  write_atomically(folder / "a[1].bvh", "x");
  EXPECT_THAT(motion_files({folder / "a[1].bvh"}), ElementsAre(folder / "a[1].bvh"));
  EXPECT_THAT(refusal_of([&] { motion_files({in + "/*.glb"}); }), HasSubstr("*.glb: there is no such file"));
  std::filesystem::create_directory(folder / "empty");
  EXPECT_THAT(refusal_of([&] { motion_files({folder / "empty"}); }), HasSubstr("without motion files"));
}

TEST(ManyFiles, ABadOneIsSkippedAndCounted) {
  std::vector<std::string> seen;
  const auto work = [&](const std::string& file) {
    seen.push_back(file);
    if (file[0] == 'x') throw Error(file, "is bad");
  };
  const FileCount count = each_file({"a", "x1", "b"}, work);
  EXPECT_EQ(count.done, 2);
  EXPECT_THAT(count.skipped, ElementsAre("x1: is bad"));
  EXPECT_THAT(seen, ElementsAre("a", "x1", "b"));
  EXPECT_EQ(refusal_of([&] { each_file({"x1"}, work); }), "x1: is bad");
  EXPECT_EQ(refusal_of([&] {
              each_file({"x1", "x2"}, work);
            }),
            "none of 2 files can be used; of the first: x1: is bad");
}

/// Sets a variable of the environment for as long as it lives.
struct Variable {
  Variable(const char* called, const std::string& value)
      : name(called), before(std::getenv(called) != nullptr ? std::getenv(called) : "") {
    setenv(name, value.c_str(), 1);
  }
  ~Variable() { before.empty() ? unsetenv(name) : setenv(name, before.c_str(), 1); }
  const char* name;
  std::string before;
};

TEST(Models, AreFoundWhereUsersAndSystemsKeepThem) {
  const TempFolder folder;
  for (const char* place : {"own", "home/inhabit/models", "system/inhabit/models"})
    std::filesystem::create_directories(folder / place);
  write_atomically(folder / "system/inhabit/models/m.safetensors", "s");
  const Variable own("INHABIT_MODELS", "/nowhere:" + folder / "own"), home("XDG_DATA_HOME", folder / "home"),
      system("XDG_DATA_DIRS", "/nowhere:" + folder / "system");
  EXPECT_EQ(shipped_model("m.safetensors"), folder / "system/inhabit/models/m.safetensors");
  write_atomically(folder / "home/inhabit/models/m.safetensors", "h");
  EXPECT_EQ(shipped_model("m.safetensors"), folder / "home/inhabit/models/m.safetensors");
  write_atomically(folder / "own/m.safetensors", "o");
  EXPECT_EQ(shipped_model("m.safetensors"), folder / "own/m.safetensors");
  EXPECT_EQ(model_file("", "m.safetensors"), folder / "own/m.safetensors");
  EXPECT_EQ(model_file("m", "other"), folder / "own/m.safetensors");
  EXPECT_EQ(model_file("some/where.safetensors", "m"), "some/where.safetensors");
  EXPECT_THAT(refusal_of([] { model_file("missing", "m"); }), HasSubstr("missing: there is no such file, nor a model"));
  EXPECT_THAT(refusal_of([] { shipped_model("missing.safetensors"); }), HasSubstr("missing.safetensors"));
}

}  // namespace
}  // namespace inhabit
