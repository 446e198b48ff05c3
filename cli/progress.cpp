#include "progress.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>

#include "verbs.h"

namespace {

using Clock = std::chrono::steady_clock;

bool quiet = false, bar_stands = false;

bool on_terminal() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && (terminal == nullptr || std::string(terminal) != "dumb");
}

std::string duration(double seconds) {
  const auto whole = std::llround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

struct ProgressLine {
  std::string what;
  bool terminal = on_terminal();
  Clock::time_point last = Clock::now(), first = last;
  int64_t before = -1;  // done at `first`, its first report: a training that is resumed begins far on; -1: none yet
  std::mutex mutex;

  void say(int64_t done, int64_t all) {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto now = Clock::now();
    const bool ends = done >= all;
    if (before < 0) {
      before = done;
      first = now;
    }
    if (terminal && ends) return end_progress();
    if (now - last < (terminal ? std::chrono::milliseconds(200) : std::chrono::seconds(10)) || all < 1) return;
    last = now;
    const double seconds = std::chrono::duration<double>(now - first).count(),
                 rate = static_cast<double>(done - before) / seconds;
    const std::string text = fmt::format(
        "{} of {}{}", done, all,
        done > before ? fmt::format(", {:.3g}/s, {} left", rate, duration(static_cast<double>(all - done) / rate))
                      : "");
    if (!terminal) {
      std::fprintf(stderr, "%s: %s\n", what.c_str(), text.c_str());
      return;
    }
    constexpr int64_t kWidth = 24;
    const auto filled = static_cast<size_t>(kWidth * done / all);
    std::fprintf(stderr, "\r%s [%s%s] %s\x1b[K", what.c_str(), std::string(filled, '#').c_str(),
                 std::string(kWidth - filled, '.').c_str(), text.c_str());
    std::fflush(stderr);
    bar_stands = true;
  }
};

}  // namespace

inhabit::Progress progress_of(const std::string& what) {
  if (quiet) return [](int64_t, int64_t) {};
  const auto progress = std::make_shared<ProgressLine>();
  progress->what = what;
  return [progress](int64_t done, int64_t all) { progress->say(done, all); };
}

void end_progress() {
  if (!bar_stands) return;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
  bar_stands = false;
}

bool is_quiet() { return quiet; }

bool shows_bars() { return !quiet && on_terminal(); }

void log_above_bars() {
  struct AboveBars : spdlog::sinks::stdout_color_sink_mt {
    void log(const spdlog::details::log_msg& message) override {
      end_progress();
      spdlog::sinks::stdout_color_sink_mt::log(message);
    }
  };
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("", std::make_shared<AboveBars>()));
}

void add_quiet(CLI::App& app) {
  for (CLI::App* verb : app.get_subcommands([](CLI::App*) { return true; })) {
    const bool below = !verb->get_subcommands([](CLI::App*) { return true; }).empty();
    if (below)
      add_quiet(*verb);
    else if (verb->get_option_no_throw("--quiet") == nullptr)
      verb->add_flag("--quiet", quiet, "Say nothing of progress and of what was detected in files")
          ->each([](const std::string&) { spdlog::set_level(spdlog::level::warn); });  // what trainings log
  }
}
