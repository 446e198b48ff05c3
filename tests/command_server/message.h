#pragma once
#include <sys/socket.h>
#include <sys/un.h>

#include <cstddef>
#include <cstring>
#include <string>

/// What a test's `inhabit` (client.cpp) and the server that runs it have in common.

/// Names the server's socket, in Linux's abstract namespace; the client's environment has it.
constexpr const char* kCommandServer = "INHABIT_COMMAND_SERVER";

/// How many descriptors go along: stdin, stdout, stderr.
constexpr int kStreams = 3;

/// The address of an abstract socket. @param size of the address
inline sockaddr_un abstract_address(const std::string& name, socklen_t& size) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, name.data(), name.size());  // at most 107 bytes: names are of our making
  size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  return address;
}
