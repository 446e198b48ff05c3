#include "inhabit/io/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "inhabit/error.h"

namespace inhabit {

FileLock::FileLock(const std::string& path, const std::string& what, bool shared) {
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(path, ignored);
  descriptor_ = ::open(path.c_str(), (folder ? O_RDONLY : O_WRONLY | O_CREAT) | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw Error(path, std::string("cannot be written: ") + std::strerror(errno));
  if (::flock(descriptor_, (shared ? LOCK_SH : LOCK_EX) | LOCK_NB) == 0) return;
  const int failed = errno;
  if (failed != EWOULDBLOCK) return;  // a file system without locks
  ::close(descriptor_);
  throw Error(path, what + " is writing it");
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace inhabit
