#include "interrupted.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <deque>
#include <string>

#include "progress.h"

namespace {

constexpr unsigned kPatience = 3;  // seconds until the next interruption point, and from there to the end

volatile std::sig_atomic_t came = 0, goes_on = 0, ending_said = 0;
std::atomic<const char*> last_words{"inhabit: interrupted\n"};  // read by the handler, in any thread

void say_last_words() {
  if (ending_said != 0) return;
  ending_said = 1;
  const char* words = last_words;
  if (write(STDERR_FILENO, words, std::strlen(words)) < 0) return;  // nobody to tell
}

/// As by the signal itself, so that a shell's loop ends too.
void die_of(int signal) {
  std::signal(signal, SIG_DFL);
  sigset_t one;
  sigemptyset(&one);
  sigaddset(&one, signal);
  pthread_sigmask(SIG_UNBLOCK, &one, nullptr);
  raise(signal);
}

void end_now(int signal) {
  say_last_words();
  die_of(signal == SIGALRM ? came : signal);
}

void interrupt(int signal) {
  if (goes_on == 0 || came != 0) return end_now(signal);
  came = signal;
  alarm(kPatience);
}

void throw_where_interrupted() {
  if (came == 0) return;
  alarm(kPatience);  // other threads may be in the middle of something long
  end_progress();
  say_last_words();
  throw CLI::RuntimeError(128 + came);
}

}  // namespace

void listen_for_interruptions() {
  std::signal(SIGALRM, end_now);
  for (const int signal : {SIGINT, SIGTERM})
    if (std::signal(signal, interrupt) == SIG_IGN) std::signal(signal, SIG_IGN);  // of a job in the background
}

void end_if_interrupted() {
  if (came != 0) die_of(came);
}

GoesOnLater::GoesOnLater(const std::string& how) : interruptible_(throw_where_interrupted) {
  static std::deque<std::string> kept;  // for as long as a handler may read
  kept.push_back("inhabit: interrupted; " + how + "\n");
  last_words = kept.back().c_str();
  goes_on = 1;
}

GoesOnLater::~GoesOnLater() { goes_on = 0; }
