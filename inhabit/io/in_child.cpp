#include "inhabit/io/in_child.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "inhabit/error.h"
#include "inhabit/interruption.h"

namespace inhabit {
namespace {

constexpr rlim_t kMostSeconds = 60;                             // of a processor
constexpr size_t kMostResult = 4ULL << 30;                      // bytes
constexpr char kResult = 'r', kRefusal = 'e', kNoMemory = 'm';  // what follows, or that nothing does

void limit(int which, rlim_t most, rlim_t hard) {
  const rlimit limits{most, hard};
  setrlimit(static_cast<__rlimit_resource>(which), &limits);
}

bool write_all(int to, const char* bytes, size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(to, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes += written;
    size -= static_cast<size_t>(written);
  }
  return true;
}

[[noreturn]] void child(int to, const std::string& subject, const std::function<std::string()>& work) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGTERM, SIGABRT, SIGSEGV, SIGPIPE}) std::signal(signal, SIG_DFL);
  std::signal(SIGINT, SIG_IGN);  // Ctrl-C is the parent's, which ends this process
  const int nowhere = ::open("/dev/null", O_RDWR);
  for (const int stream : {0, 1, 2}) dup2(nowhere, stream);  // assertions print; so do libraries
  limit(RLIMIT_CORE, 0, 0);
  limit(RLIMIT_CPU, kMostSeconds, kMostSeconds + 5);  // at the second, SIGKILL would say nothing
#ifndef __SANITIZE_ADDRESS__                          // whose shadow takes terabytes of addresses
  const rlim_t half = static_cast<rlim_t>(sysconf(_SC_PHYS_PAGES)) / 2 * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
  limit(RLIMIT_DATA, half, half);
#endif
  char kind = kResult;
  std::string text;
  try {
    text = work();
  } catch (const Error& e) {
    kind = kRefusal;
    text = e.what();
  } catch (const std::bad_alloc&) {
    kind = kNoMemory;
  } catch (const std::exception& e) {
    kind = kRefusal;
    text = subject + ": " + e.what();
  }
  const bool whole = write_all(to, &kind, 1) && write_all(to, text.data(), text.size());
  _exit(whole ? 0 : 1);
}

/// All that the child writes; Ctrl-C and the like end it.
std::string all_of(int from, pid_t pid) {
  std::string out;
  char buffer[1 << 16];
  try {
    for (;;) {
      interruption_point();
      pollfd ready{from, POLLIN, 0};
      if (::poll(&ready, 1, 200) <= 0) continue;
      const ssize_t got = ::read(from, buffer, sizeof buffer);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return out;
      if (out.size() + static_cast<size_t>(got) > kMostResult) return {};
      out.append(buffer, static_cast<size_t>(got));
    }
  } catch (...) {
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
    ::close(from);
    throw;
  }
}

}  // namespace

std::string in_child(const std::string& subject, const std::function<std::string()>& work) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw Error(subject, std::string("no pipe to read it: ") + std::strerror(errno));
  const pid_t pid = ::fork();
  if (pid < 0) {
    const int why = errno;
    ::close(ends[0]);
    ::close(ends[1]);
    throw Error(subject, std::string("no process to read it: ") + std::strerror(why));
  }
  if (pid == 0) {
    ::close(ends[0]);
    child(ends[1], subject, work);
  }
  ::close(ends[1]);
  std::string out = all_of(ends[0], pid);
  ::close(ends[0]);
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && !out.empty()) {
    const char kind = out.front();
    out.erase(0, 1);
    if (kind == kResult) return out;
    if (kind == kRefusal) throw Error(out);
    throw Error(subject, "asks for more memory than it may have");
  }
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) throw Error(subject, "takes over a minute to read");
  throw Error(subject, "is damaged, or of a kind, that breaks its reader");
}

}  // namespace inhabit
