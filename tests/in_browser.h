#pragma once
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "inhabit/io/atomic_file.h"
#include "temp_folder.h"

namespace inhabit {

constexpr int kNoBrowser = 77;

/// Runs viewer/test/SCRIPT, which opens the pages of `folder` in headless Chromium. @param said what it prints.
/// @param url of a page that is served, the script's first argument then; empty: none
/// @return its exit code: kNoBrowser where there is no Chromium
inline int in_browser(const std::string& script, const TempFolder& folder, std::string& said,
                      const std::string& url = "") {
  const std::string log = folder / "log.txt";
  const std::string line = "node '" INHABIT_SOURCE_DIR "/viewer/test/" + script + "' " + url + " '" +
                           folder.path.string() + "' > '" + log + "' 2>&1";
  const int status = std::system(line.c_str());
  said = read_whole_file(log);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace inhabit
