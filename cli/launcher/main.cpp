// `inhabit` itself: small, so that it is there at once. It sets what OpenMP reads before main() runs and becomes the
// program of the verbs, which loads LibTorch, once.
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "../version.h"
#include "inhabit/thread_variables.h"

namespace fs = std::filesystem;

int main(int argc, char** argv) {
  if (argc == 2 && (std::string_view(argv[1]) == "--version" || std::string_view(argv[1]) == "version")) {
    std::puts(kVersions);
    return std::fflush(stdout) == 0 ? 0 : 2;
  }
  std::error_code none;
  const fs::path folder = fs::read_symlink("/proc/self/exe", none).parent_path();
  if (folder.empty()) {
    std::fprintf(stderr, "inhabit: /proc/self/exe, which tells where inhabit's programs are, cannot be read\n");
    return 3;
  }
  const fs::path beside = folder / INHABIT_VERBS, installed = folder / INHABIT_VERBS_INSTALLED;
  const fs::path verbs = fs::exists(beside, none) ? beside : installed;
  inhabit::set_thread_variables();
  execv(verbs.c_str(), argv);
  std::fprintf(stderr, "inhabit: %s: cannot be started: %s\n", verbs.c_str(), std::strerror(errno));
  return 3;
}
