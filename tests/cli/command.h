#pragma once
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

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

/// Runs `inhabit ARGUMENTS` in a shell.
inline CommandResult run_command(const std::string& arguments) {
  return run_program(std::string(INHABIT_COMMAND) + " " + arguments);
}
