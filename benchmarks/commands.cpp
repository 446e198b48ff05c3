// The command as a user runs it, a process each time: process start, reading, the model, writing. `floor` is what no
// verb goes below: a process that loads LibTorch, reads the motion and says what it holds. Counters: seconds of all
// cores and peak memory of the process. Other inputs than the bundled ones: commands_benchmark MOTION SCENE.
#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

/// What one run took; `failed` where it did not exit with 0.
struct Run {
  double cpu_seconds = 0, peak_mb = 0;
  bool failed = false;
};

Run run(const std::vector<std::string>& arguments) {
  std::vector<char*> argv;
  static std::string command = INHABIT_COMMAND;
  argv.push_back(command.data());
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    unsetenv("OMP_WAIT_POLICY");  // the command sets it itself
    execv(argv[0], argv.data());
    _exit(127);
  }
  int status = 0;
  rusage used{};
  wait4(child, &status, 0, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {seconds(used.ru_utime) + seconds(used.ru_stime), static_cast<double>(used.ru_maxrss) / 1024,
          !WIFEXITED(status) || WEXITSTATUS(status) != 0};
}

void measure(benchmark::State& state, const std::vector<std::string>& arguments) {
  Run most;
  for (auto _ : state) {
    const Run one = run(arguments);
    if (one.failed) return state.SkipWithError("the command failed");
    most.cpu_seconds += one.cpu_seconds;
    most.peak_mb = std::max(most.peak_mb, one.peak_mb);
  }
  state.counters["cpu_s"] = benchmark::Counter(most.cpu_seconds, benchmark::Counter::kAvgIterations);
  state.counters["peak_mb"] = most.peak_mb;
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const std::string data = INHABIT_SOURCE_DIR "/examples/data/", motion = argc > 2 ? argv[1] : data + "sit.npz",
                    scene = argc > 2 ? argv[2] : data + "sit_room.glb", walk = data + "walk.npz",
                    walk_room = data + "walk_room.glb",
                    out = fs::temp_directory_path() / ("inhabit_commands_" + std::to_string(getpid()));
  const std::string npz = out + ".npz", html = out + ".html";
  const std::vector<std::string> futures = {"anticipate", walk, "--samples", "50", "--seconds", "30", "-o"},
                                 between = {"inbetween", motion, "--scene", scene, "--keyframes", "every:60", "-o"};
  const auto with = [](std::vector<std::string> arguments, const std::string& more) {
    arguments.push_back(more);
    return arguments;
  };
  const std::vector<std::pair<std::string, std::vector<std::string>>> rows = {
      {"version", {"--version"}},
      {"floor/info", {"info", walk}},
      {"forecast/npz", {"forecast", walk, "--scene", walk_room, "--start", "30", "-o", npz}},
      {"anticipate_50_of_30_s/npz", with(futures, npz)},
      {"anticipate_50_of_30_s/html", with(futures, html)},
      {"inbetween/npz", with(between, npz)},
      {"inbetween/html", with(between, html)}};
  for (const auto& [name, arguments] : rows)
    benchmark::RegisterBenchmark(name.c_str(), [arguments = arguments](benchmark::State& s) { measure(s, arguments); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  benchmark::RunSpecifiedBenchmarks();
  fs::remove(npz);
  fs::remove(html);
}
