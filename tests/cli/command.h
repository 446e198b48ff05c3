#pragma once
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "command_server/message.h"
#include "inhabit/thread_variables.h"
#include "temp_folder.h"

/// What one run of the command left behind.
struct CommandResult {
  int exit_code = -1;
  std::string out, err;
};

/// Runs a program in a shell.
inline CommandResult run_program(const std::string& command) {
  const auto err_path = std::filesystem::temp_directory_path() / ("inhabit_err_" + std::to_string(::getpid()));
  const std::string line = command + " 2>" + err_path.string();
  CommandResult result;
  FILE* pipe = popen(line.c_str(), "r");
  std::array<char, 4096> buffer{};
  size_t n = 0;
  while ((n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0) result.out.append(buffer.data(), n);
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  std::ifstream err(err_path);
  std::stringstream text;
  text << err.rdbuf();
  result.err = text.str();
  std::filesystem::remove(err_path);
  return result;
}

/// What runs `inhabit` as INHABIT_COMMAND does, without waiting for LibTorch (tests/command_server): a server that is
/// started once and ends with this process.
inline const char* command_at_hand() {
  static const bool started = [] {
    const std::string name = "inhabit_test_" + std::to_string(::getpid());
    setenv(kCommandServer, name.c_str(), 1);
    int ready[2] = {-1, -1};
    if (pipe(ready) != 0) return false;
    if (fork() == 0) {
      close(ready[0]);
      inhabit::set_thread_variables();
      const std::string end = std::to_string(ready[1]);
      execl(INHABIT_COMMAND_SERVER_PROGRAM, "inhabit_command_server", name.c_str(), end.c_str(), nullptr);
      _exit(3);
    }
    close(ready[1]);
    char none = 0;
    const bool listens = read(ready[0], &none, 1) == 1;
    close(ready[0]);
    return listens;
  }();
  EXPECT_TRUE(started);
  return INHABIT_COMMAND_CLIENT;
}

/// Runs `inhabit ARGUMENTS` in a shell.
inline CommandResult run_command(const std::string& arguments) {
  return run_program(std::string(command_at_hand()) + " " + arguments);
}
