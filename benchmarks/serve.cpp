// The live page's server with the model that ships and 1, 30 and 100 pages connected, each with a person who is told
// where to go four times a second. One page is watched: `latency` is the milliseconds from sending a message to the
// first frame that knows of it (median, 99 %, largest), `fps` frames a second that a page gets, `late` the fraction of
// steps left out for want of time, `MB` what a page costs the server and the pages together, `cores` the processor time
// of all of them. Pages and server share this process and its cores.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <thread>

#include "inhabit/serve/server.h"
#include "inhabit/thread_variables.h"
#include "tests/serve/client.h"

namespace {

using namespace inhabit;
using serve::LiveClient;
using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

double resident_mb() {
  std::ifstream status("/proc/self/statm");
  double size = 0, resident = 0;
  status >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

double processor_seconds() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

const std::shared_ptr<const serve::World>& world() {
  static const auto it = serve::make_world(
      serve::default_room(), serve::ModelFiles{INHABIT_SOURCE_DIR "/models/interact-compact.safetensors", "", "", ""});
  return it;
}

/// What people are told, one after the other.
nlohmann::json order(uint32_t number) {
  const auto& seats = world()->seats;
  return {{"do", "sit"}, {"chair", seats[number / 40 % seats.size()].chair.name}, {"number", number}};
}

void live(benchmark::State& state) {
  const auto count = static_cast<size_t>(state.range(0));
  serve::Server server(world(), {});
  std::thread serving([&] { server.run(); });
  const double before = resident_mb();
  std::vector<std::thread> others;
  std::atomic<bool> ending = false;
  for (size_t i = 1; i < count; ++i)
    others.emplace_back([&, i] {
      LiveClient page(server.port());
      for (uint32_t frame = 0; !ending; ++frame) {
        page.pose();
        if ((frame + i) % 8 == 0) page.send(order(frame / 8));
      }
    });
  std::vector<double> latencies;
  double seconds = 0, cores = 0;
  int64_t frames = 0;
  for (auto _ : state) {
    LiveClient page(server.port());
    for (int i = 0; i < 60; ++i) page.pose();  // until all are there
    latencies.clear();
    const auto began = Clock::now();
    const double used = processor_seconds();
    const int64_t sent = server.stats().frames;
    for (uint32_t number = 1; number <= 100; ++number) {
      for (uint32_t i = 0; i < 1 + number % 3; ++i) page.pose();
      std::this_thread::sleep_for(std::chrono::milliseconds(7 * number % 33));  // anywhere between two frames
      const auto asked = Clock::now();
      page.send(order(number));
      while (serve::number_at<uint32_t>(page.pose(), 8) < number) continue;
      latencies.push_back(Milliseconds(Clock::now() - asked).count());
    }
    seconds = std::chrono::duration<double>(Clock::now() - began).count();
    cores = (processor_seconds() - used) / seconds;
    frames = server.stats().frames - sent;
  }
  const serve::ServerStats stats = server.stats();
  state.counters["MB"] = (resident_mb() - before) / static_cast<double>(count);
  ending = true;
  for (std::thread& other : others) other.join();
  server.stop();
  serving.join();
  std::sort(latencies.begin(), latencies.end());
  state.counters["latency"] = latencies[latencies.size() / 2];
  state.counters["latency_99"] = latencies[latencies.size() * 99 / 100];
  state.counters["latency_most"] = latencies.back();
  state.counters["fps"] = static_cast<double>(frames) / seconds / static_cast<double>(count);
  state.counters["late"] =
      static_cast<double>(stats.late) / static_cast<double>(stats.late + stats.frames + stats.dropped);
  state.counters["cores"] = cores;
}

BENCHMARK(live)->Arg(1)->Arg(30)->Arg(100)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace

int main(int argc, char** argv) {
  inhabit::start_with_thread_variables(argv);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
