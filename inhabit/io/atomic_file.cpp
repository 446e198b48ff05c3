#include "inhabit/io/atomic_file.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "inhabit/error.h"

namespace inhabit {
namespace fs = std::filesystem;

void write_atomically(const std::string& path, const std::function<void(std::ostream&)>& write) {
  std::error_code ignored;
  const fs::path target(path);
  if (path.empty()) throw Error("an output file has an empty name");
  if (fs::is_directory(target, ignored)) throw Error(path, "cannot be written: it is a folder");
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored)) throw Error(path, "cannot be written: there is no folder " + folder.string());

  const bool in_place = fs::exists(target, ignored) && !fs::is_regular_file(target, ignored);
  static std::atomic<unsigned> count{0};  // two threads may write to one folder
  const fs::path file = in_place ? target
                                 : folder / ("." + target.filename().string() + "." + std::to_string(::getpid()) + "." +
                                             std::to_string(count++) + ".part");
  errno = 0;
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  if (!stream) throw Error(path, std::string("cannot be written: ") + std::strerror(errno));
  auto discard = [&] {
    stream.close();
    if (!in_place) fs::remove(file, ignored);
  };
  errno = 0;
  try {
    write(stream);
  } catch (...) {
    discard();
    throw;
  }
  int failure = stream ? 0 : errno;
  errno = 0;
  stream.close();
  if (!stream) {
    if (failure == 0) failure = errno;
    const std::string reason = failure != 0 ? std::strerror(failure) : "the disk refused the data";
    discard();
    throw Error(path, "cannot be written: " + reason);
  }
  if (in_place) return;
  std::error_code failed;
  fs::rename(file, target, failed);
  if (failed) {
    discard();
    throw Error(path, "cannot be written: " + failed.message());
  }
}

void write_atomically(const std::string& path, std::string_view bytes) {
  write_atomically(
      path, [&](std::ostream& stream) { stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

std::string read_whole_file(const std::string& path, uint64_t limit) {
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  if (!fs::exists(status)) throw Error(path, "there is no such file");
  if (fs::is_directory(status)) throw Error(path, "is a folder, not a file");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(path, std::string("cannot be read: ") + std::strerror(errno));
  std::string bytes;
  if (fs::is_regular_file(status)) {
    const uint64_t size = fs::file_size(path, failed);
    if (!failed && size > limit)
      throw Error(path, "is too large: " + std::to_string(size >> 20) + " MiB where " + std::to_string(limit >> 20) +
                            " MiB is the limit");
    if (!failed) bytes.reserve(size);
  }
  std::string block(size_t{1} << 16, '\0');
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0) {
    bytes.append(block.data(), static_cast<size_t>(stream.gcount()));
    if (bytes.size() > limit) throw Error(path, "is too large: more than " + std::to_string(limit >> 20) + " MiB");
  }
  if (stream.bad()) throw Error(path, "cannot be read to its end");
  return bytes;
}

}  // namespace inhabit
