#include "inhabit/serve/recording_file.h"

#include <cstdlib>
#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"

namespace inhabit::serve {
namespace {

namespace fs = std::filesystem;

/// A folder that only this process knows, for as long as this lives.
struct PrivateFolder {
  fs::path path;
  PrivateFolder() {
    std::string name = (fs::temp_directory_path() / "inhabit_serve_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw Error(name, "cannot be made");
    path = name;
  }
  ~PrivateFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
};

}  // namespace

std::string recording_file(const World& world, const std::vector<Frame>& frames, const std::string& extension) {
  if (frames.empty()) throw Error("recording", "has no frame");
  const PrivateFolder folder;
  const std::string path = (folder.path / ("recording." + extension)).string();
  write_clip(path, clip_of(frames, world.person), &world.scene);
  return read_whole_file(path);
}

}  // namespace inhabit::serve
