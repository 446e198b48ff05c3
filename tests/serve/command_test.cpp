// Protects `inhabit serve` as it is run: with the model that ships it serves a page in which somebody who is clicked to
// a chair sits down on it, and it ends when it is interrupted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <csignal>

#include "cli/refusal.h"
#include "client.h"
#include "in_browser.h"

namespace inhabit::serve {
namespace {

using testing::HasSubstr;

/// `inhabit serve --port 0 ARGUMENTS` while this lives.
struct RunningCommand {
  pid_t pid = -1;
  FILE* out = nullptr;
  std::string line;  ///< that it prints first
  uint16_t port = 0;

  explicit RunningCommand(const std::vector<std::string>& arguments = {}) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
    pid = fork();
    if (pid == 0) {
      dup2(ends[1], 1);
      close(ends[0]);
      close(ends[1]);
      std::vector<std::string> all = {INHABIT_COMMAND, "serve", "--port", "0"};
      all.insert(all.end(), arguments.begin(), arguments.end());
      std::vector<char*> argv;
      for (std::string& argument : all) argv.push_back(argument.data());
      argv.push_back(nullptr);
      execv(INHABIT_COMMAND, argv.data());
      _exit(127);
    }
    close(ends[1]);
    out = fdopen(ends[0], "r");
    std::array<char, 256> buffer{};
    if (fgets(buffer.data(), buffer.size(), out) != nullptr) line = buffer.data();
    if (const size_t colon = line.rfind(':', line.find('/', 8)); colon != std::string::npos)
      port = static_cast<uint16_t>(std::strtoul(line.c_str() + colon + 1, nullptr, 10));
  }
  /// Interrupts it, as Ctrl-C does. @return its exit code; 128 and more where a signal ended it
  int interrupt(int signal = SIGINT) {
    kill(pid, signal);
    int status = 0;
    waitpid(pid, &status, 0);
    pid = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  ~RunningCommand() {
    if (pid > 0) interrupt(SIGKILL);
    fclose(out);
  }
};

TEST(ServeCommand, ServesAndEndsWhenInterrupted) {
  RunningCommand command;
  ASSERT_GT(command.port, 0) << command.line;
  EXPECT_EQ(command.line, "http://" + host_of(command.port) + "/ (Ctrl-C ends it)\n");
  EXPECT_EQ(ask(command.port, "/").result_int(), 200);
  LiveClient client(command.port);
  const nlohmann::json hello = client.event("hello");
  EXPECT_EQ(hello["chairs"].size(), 4);
  EXPECT_TRUE(hello["contacts"].get<bool>() && hello["forecast"].get<bool>() && hello["futures"].get<bool>());
  EXPECT_GE(hello["poses"].size(), 5);
  EXPECT_EQ(command.interrupt(), 0);
  EXPECT_EQ(client.closed().code, beast::websocket::close_code::going_away);
}

TEST(ServeCommand, BadInputIsRefusedInOneLine) {
  const TempFolder folder;
  expect_refused("serve --scene " + folder / "none.glb", {"none.glb"}, folder.path.string());
  expect_refused("serve --model " INHABIT_SOURCE_DIR "/models/forecast-compact.safetensors", {"forecast-compact"},
                 folder.path.string());
  expect_refused("serve --port 70000", {"--port"}, folder.path.string());
  expect_refused("serve --port x", {"--port"}, folder.path.string());
  RunningCommand command;
  expect_refused("serve --port " + std::to_string(command.port), {"port " + std::to_string(command.port)},
                 folder.path.string());
}

// What a visitor does: viewer/test/live_test.mjs clicks in headless Chromium.
TEST(LivePageInBrowser, WalksSitsAndReaches) {
  const TempFolder folder;
  RunningCommand command;
  ASSERT_GT(command.port, 0) << command.line;
  std::string said;
  const int status = in_browser("live_test.mjs", folder, said, "http://" + host_of(command.port) + "/");
  if (status == kNoBrowser) GTEST_SKIP() << said;
  EXPECT_EQ(status, 0) << said;
  EXPECT_EQ(command.interrupt(), 0);
}

}  // namespace
}  // namespace inhabit::serve
