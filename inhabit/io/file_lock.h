#pragma once
#include <string>

namespace inhabit {

/// Keeps other processes from what this one writes, as long as it lives: an advisory lock (flock) of an existing file
/// or folder, which the system lets go when the process ends in whatever way.
class FileLock {
 public:
  /// @param path a file, made where there is none, or a folder; @param what is said to be writing it ("another
  /// training"); @param shared with others that share it. Throws Error(path, ...) where another process, or another
  /// lock of this one, has it.
  FileLock(const std::string& path, const std::string& what, bool shared = false);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace inhabit
