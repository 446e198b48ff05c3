// Runs `inhabit` for tests, each time in a process forked from this one, which has LibTorch loaded: half a second that
// the hundreds of short commands of a test run need not wait for. What main() does not see, such as how the launcher
// starts the program, tests run as users do (run_program(INHABIT_COMMAND ...)).
// usage: inhabit_command_server NAME FD    NAME: of the abstract socket; FD: gets a byte once it listens
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "cli/command_line.h"
#include "inhabit/thread_variables.h"
#include "message.h"

namespace {

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  std::_Exit(3);
}

std::string read_text(int client, int (&streams)[kStreams]) {
  uint32_t length = 0;
  iovec head{&length, sizeof length};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof streams)]{};
  msghdr message{};
  message.msg_iov = &head;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  if (recvmsg(client, &message, MSG_WAITALL) != sizeof length) fail("recvmsg");
  const cmsghdr* rights = CMSG_FIRSTHDR(&message);
  if (rights == nullptr) fail("no streams");
  std::memcpy(streams, CMSG_DATA(rights), sizeof streams);
  std::string text(length, '\0');
  for (size_t got = 0; got < length;) {
    const ssize_t n = read(client, text.data() + got, length - got);
    if (n <= 0) fail("read");
    got += static_cast<size_t>(n);
  }
  return text;
}

/// The process of one command becomes it.
[[noreturn]] void become(std::string text, const int (&streams)[kStreams]) {
  for (int i = 0; i < kStreams; ++i) dup2(streams[i], i);
  for (const int stream : streams)
    if (stream >= kStreams) close(stream);
  std::vector<char*> strings;
  for (size_t at = 0; at < text.size(); at += std::char_traits<char>::length(text.data() + at) + 1)
    strings.push_back(text.data() + at);
  if (chdir(strings[0]) != 0) fail(strings[0]);
  const size_t count = std::stoul(strings[1]);
  clearenv();
  for (size_t i = 2 + count; i < strings.size(); ++i) putenv(strings[i]);
  inhabit::set_thread_variables();
  std::vector<char*> arguments(strings.begin() + 2, strings.begin() + 2 + static_cast<std::ptrdiff_t>(count));
  arguments.push_back(nullptr);
  leave(run_command_line(static_cast<int>(count), arguments.data()));
}

/// In a process of its own: runs what the client asks for and tells it how that ended.
[[noreturn]] void serve(int client) {
  int streams[kStreams];
  std::string text = read_text(client, streams);
  const pid_t command = fork();
  if (command == 0) {
    close(client);
    become(std::move(text), streams);
  }
  int status = 0;
  if (command < 0 || waitpid(command, &status, 0) < 0) fail("fork");
  const int32_t ended = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  std::_Exit(write(client, &ended, sizeof ended) == sizeof ended ? 0 : 3);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // it ends with the test
  const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  socklen_t size = 0;
  const sockaddr_un address = abstract_address(argv[1], size);
  if (bind(listener, reinterpret_cast<const sockaddr*>(&address), size) != 0 || listen(listener, 64) != 0)
    fail("listen");
  const int ready = std::stoi(argv[2]);
  if (write(ready, "", 1) != 1) fail("ready");
  close(ready);
  while (true) {
    const int client = accept(listener, nullptr, nullptr);
    if (client < 0) continue;
    while (waitpid(-1, nullptr, WNOHANG) > 0) {
    }
    const pid_t served = fork();
    if (served == 0) {
      close(listener);
      serve(client);
    }
    close(client);
    if (served < 0) fail("fork");
  }
}
