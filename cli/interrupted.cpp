#include "interrupted.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <string>

#include "progress.h"

namespace {

constexpr unsigned kPatience = 3;  // seconds until the next interruption point
constexpr int kEnded = 128;        // and the signal's number, as shells say of what a signal ended

volatile std::sig_atomic_t came = 0, goes_on = 0;
std::string last_words = "inhabit: interrupted\n";  // what the handler writes; changed while it does not run

void set_last_words(const std::string& how) {
  sigset_t both, before;
  sigemptyset(&both);
  for (const int signal : {SIGINT, SIGTERM, SIGALRM}) sigaddset(&both, signal);
  pthread_sigmask(SIG_BLOCK, &both, &before);
  last_words = "inhabit: interrupted" + (how.empty() ? "" : "; " + how) + "\n";
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

[[noreturn]] void end_now(int signal) {
  const int code = kEnded + (signal == SIGALRM ? came : signal);
  if (write(STDERR_FILENO, last_words.data(), last_words.size()) < 0) _exit(code);
  _exit(code);
}

void interrupt(int signal) {
  if (goes_on == 0 || came != 0) end_now(signal);
  came = signal;
  alarm(kPatience);
}

void throw_where_interrupted() {
  if (came == 0) return;
  alarm(0);
  end_progress();
  std::fputs(last_words.c_str(), stderr);
  throw CLI::RuntimeError(kEnded + came);
}

}  // namespace

void listen_for_interruptions() {
  std::signal(SIGALRM, end_now);
  for (const int signal : {SIGINT, SIGTERM})
    if (std::signal(signal, interrupt) == SIG_IGN) std::signal(signal, SIG_IGN);  // of a job in the background
}

GoesOnLater::GoesOnLater(const std::string& how) : interruptible_(throw_where_interrupted) {
  set_last_words(how);
  goes_on = 1;
}

GoesOnLater::~GoesOnLater() {
  goes_on = 0;
  set_last_words("");
}
