// Stands in for `inhabit` where a test runs it: hands its arguments, folder, environment and streams to the server
// (server.cpp) and ends as the command does.
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "message.h"

extern char** environ;

namespace {

int fails(const char* what) {
  std::perror(what);
  return 3;
}

}  // namespace

int main(int, char** argv) {
  const char* name = std::getenv(kCommandServer);
  const int server = socket(AF_UNIX, SOCK_STREAM, 0);
  socklen_t size = 0;
  const sockaddr_un address = abstract_address(name != nullptr ? name : "", size);
  if (connect(server, reinterpret_cast<const sockaddr*>(&address), size) != 0) return fails("the command server");

  // Strings that end with zeros: the folder, the number of arguments, these, the environment.
  int count = 0;
  while (argv[count] != nullptr) ++count;
  std::string text = std::filesystem::current_path().string() + '\0' + std::to_string(count) + '\0';
  for (char** argument = argv; *argument != nullptr; ++argument) text += std::string(*argument) + '\0';
  for (char** variable = environ; *variable != nullptr; ++variable) text += std::string(*variable) + '\0';

  const auto length = static_cast<uint32_t>(text.size());
  iovec head{const_cast<uint32_t*>(&length), sizeof length};
  alignas(cmsghdr) char control[CMSG_SPACE(kStreams * sizeof(int))]{};
  msghdr message{};
  message.msg_iov = &head;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  cmsghdr* rights = CMSG_FIRSTHDR(&message);
  rights->cmsg_level = SOL_SOCKET;
  rights->cmsg_type = SCM_RIGHTS;
  rights->cmsg_len = CMSG_LEN(kStreams * sizeof(int));
  const int streams[kStreams] = {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO};
  std::memcpy(CMSG_DATA(rights), streams, sizeof streams);
  if (sendmsg(server, &message, 0) != sizeof length) return fails("the command server");
  for (size_t sent = 0; sent < text.size();) {
    const ssize_t n = write(server, text.data() + sent, text.size() - sent);
    if (n <= 0) return fails("the command server");
    sent += static_cast<size_t>(n);
  }

  int32_t ended = 0;  // the exit code, or a signal's negated number
  if (read(server, &ended, sizeof ended) != sizeof ended) return fails("the command server");
  if (ended >= 0) return ended;
  std::signal(-ended, SIG_DFL);
  raise(-ended);
  return 128 - ended;
}
