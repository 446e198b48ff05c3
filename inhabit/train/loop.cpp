#include "inhabit/train/loop.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "inhabit/error.h"
#include "inhabit/io/file_lock.h"
#include "inhabit/math/random.h"
#include "inhabit/train/average.h"
#include "inhabit/train/checkpoint.h"
#include "inhabit/train/memory.h"

namespace inhabit {
namespace {

volatile std::sig_atomic_t stop_requested = 0;
void request_stop(int) { stop_requested = 1; }

/// SIGINT and SIGTERM ask the loop to stop after the step at hand, while one of these lives.
struct StopOnSignal {
  decltype(std::signal(SIGINT, SIG_DFL)) interrupt, terminate;
  StopOnSignal() : interrupt(std::signal(SIGINT, request_stop)), terminate(std::signal(SIGTERM, request_stop)) {
    stop_requested = 0;
  }
  ~StopOnSignal() {
    std::signal(SIGINT, interrupt);
    std::signal(SIGTERM, terminate);
  }
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;
};

/// The batches of a run, by step alone. Every epoch is a fresh permutation; one that does not divide goes on into the
/// next.
class Order {
 public:
  Order(int64_t samples, int64_t batch, uint64_t seed) : samples_(samples), batch_(batch), seed_(seed) {}
  std::vector<int64_t> indices(int64_t step) {
    std::vector<int64_t> out;
    for (int64_t i = step * batch_; i < (step + 1) * batch_; ++i) {
      permute(i / samples_);
      out.push_back(permutation_[static_cast<size_t>(i % samples_)]);
    }
    return out;
  }

 private:
  void permute(int64_t epoch) {
    if (epoch == epoch_) return;
    epoch_ = epoch;
    permutation_.resize(static_cast<size_t>(samples_));
    std::iota(permutation_.begin(), permutation_.end(), 0);
    std::mt19937_64 random(item_seed(seed_, static_cast<uint64_t>(epoch)));
    for (int64_t i = samples_ - 1; i > 0; --i)
      std::swap(permutation_[static_cast<size_t>(i)],
                permutation_[static_cast<size_t>(uniform_int(random, 0, static_cast<int>(i)))]);
  }
  int64_t samples_, batch_, epoch_ = -1;
  uint64_t seed_;
  std::vector<int64_t> permutation_;
};

double scheduled_rate(const TrainOptions& options, int64_t step) {
  const double progress = static_cast<double>(step) / static_cast<double>(options.steps);
  const double risen = (progress + 1.0 / static_cast<double>(options.steps)) / std::max(options.warmup, 1e-9);
  const double cosine = 0.5 * (1 + std::cos(M_PI * progress));
  return options.learning_rate * std::min(1.0, risen) * (options.floor + (1 - options.floor) * cosine);
}

/// Parameters with the same factor of the learning rate, by the factor.
std::map<double, std::vector<torch::Tensor>> rate_groups(const TrainTask& task) {
  std::map<double, std::vector<torch::Tensor>> groups;
  for (const auto& p : task.module->named_parameters())
    groups[task.rate_factor ? task.rate_factor(p.key()) : 1.0].push_back(p.value());
  return groups;
}

/// Gradients become their mean over the ranks. True where any of them is to stop.
bool average_gradients(torch::nn::Module& module, const DataParallel& ranks, bool stop) {
  std::vector<torch::Tensor> sent;
  for (torch::Tensor& p : module.parameters()) {
    if (!p.requires_grad()) continue;
    if (!p.grad().defined()) p.mutable_grad() = torch::zeros_like(p);  // this rank's part did not touch it
    sent.push_back(p.grad());
  }
  torch::Tensor stopping = torch::full({1}, stop ? 1. : 0., sent.empty() ? torch::TensorOptions() : sent[0].options());
  sent.push_back(stopping);
  ranks.average(sent);
  return stopping.item<double>() > 0;
}

std::string clock_text(double seconds) {
  const auto s = static_cast<int64_t>(seconds);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace

TrainResult train(const TrainTask& task, const TrainOptions& options) {
  if (task.samples == 0) throw Error("the data set has no training window long enough for " + task.name);
  keep_freed_memory();
  const auto groups = rate_groups(task);
  std::vector<torch::optim::OptimizerParamGroup> optimised;
  optimised.reserve(groups.size());
  for (const auto& [factor, parameters] : groups) optimised.emplace_back(parameters);
  torch::optim::AdamW optimizer(optimised,
                                torch::optim::AdamWOptions(options.learning_rate).weight_decay(task.weight_decay));
  const std::shared_ptr<DataParallel> ranks = options.ranks;
  const int rank = ranks ? ranks->rank() : 0, rank_count = ranks ? ranks->size() : 1;
  std::optional<WeightAverage> average;
  if (task.average > 0) average.emplace(task.module, task.average);
  std::map<std::string, torch::Tensor> no_average;
  std::map<std::string, torch::Tensor>& averaged = average ? average->weights() : no_average;
  TrainResult result;
  result.best = std::numeric_limits<double>::infinity();
  int64_t first_step = 0;
  double seconds_before = 0;
  const std::string run = fmt::format("{} steps {} batch {} rate {} samples {} seed {}{}{}", task.name, options.steps,
                                      options.batch * rank_count, options.learning_rate, task.samples, options.seed,
                                      task.settings.empty() ? "" : " ", task.settings);
  if (options.resume) {
    auto state = load_checkpoint(options.checkpoint, *task.module, optimizer, averaged);
    if (state["run"] != run)
      throw Error(options.checkpoint, "belongs to another run (" + state["run"] + "; this one is " + run + ")");
    const auto number = [&](const char* key) { return checkpoint_number(state, key, options.checkpoint); };
    first_step = static_cast<int64_t>(std::clamp(number("step"), 0.0, static_cast<double>(options.steps)));
    seconds_before = number("seconds");
    result.best = number("best");
    result.best_step = static_cast<int64_t>(std::clamp(number("best_step"), 0.0, static_cast<double>(options.steps)));
  }

  if (ranks) {
    std::vector<torch::Tensor> weights;
    for (const auto& p : task.module->named_parameters()) weights.push_back(p.value().detach());
    for (const auto& b : task.module->named_buffers()) weights.push_back(b.value());
    ranks->broadcast(weights);
  }

  StopOnSignal stop;
  std::ofstream log;
  std::optional<FileLock> lock;  // of the log: the files of weights are replaced by others at each writing
  if (rank == 0 && !options.log.empty()) {
    lock.emplace(options.log, "another training");
    log.open(options.log, options.append_log ? std::ios::app : std::ios::trunc);
    if (!log) throw Error(options.log, "cannot be written");
  }
  Order order(task.samples, options.batch * rank_count, options.seed);
  // A rank draws from seeds of its own; those of rank 0 are those of a run of one.
  const auto seed_of = [&](uint64_t stream, int64_t step) {
    const uint64_t seed = item_seed(options.seed + stream, static_cast<uint64_t>(step));
    return rank == 0 ? seed : item_seed(seed, static_cast<uint64_t>(rank));
  };
  auto prepare = [&](int64_t step) {
    const std::vector<int64_t> all = order.indices(step);
    const auto first = all.begin() + rank * options.batch;
    return task.prepare({step, {first, first + options.batch}, seed_of(1, step)});
  };
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  auto seconds = [&] { return seconds_before + std::chrono::duration<double>(Clock::now() - start).count(); };
  auto save = [&](int64_t step) {
    if (rank != 0) return;
    save_checkpoint(options.checkpoint, *task.module, optimizer, averaged,
                    {{"run", run},
                     {"step", std::to_string(step)},
                     {"seconds", std::to_string(seconds())},
                     {"best", fmt::format("{}", result.best)},
                     {"best_step", std::to_string(result.best_step)}});
  };
  double last_report = -1e9, reported_seconds = seconds();
  int64_t reported_step = first_step;

  if (!options.resume) save(0);  // so that a run that ends before its first checkpoint can be resumed too

  std::future<std::function<Losses()>> next = std::async(std::launch::async, prepare, first_step);
  for (int64_t step = first_step; step < options.steps; ++step) {
    const std::function<Losses()> losses_of_batch = next.get();
    if (step + 1 < options.steps) next = std::async(std::launch::async, prepare, step + 1);
    const double rate = scheduled_rate(options, step);
    for (auto [group, i] = std::pair(groups.begin(), size_t{0}); group != groups.end(); ++group, ++i)
      static_cast<torch::optim::AdamWOptions&>(optimizer.param_groups()[i].options()).lr(rate * group->first);

    task.module->train();
    torch::manual_seed(seed_of(2, step));  // of dropout
    optimizer.zero_grad();
    const Losses losses = losses_of_batch();
    losses.front().second.backward();
    bool stop_now = stop_requested != 0;
    if (ranks) stop_now = average_gradients(*task.module, *ranks, stop_now);
    torch::nn::utils::clip_grad_norm_(task.module->parameters(), 1.0);
    optimizer.step();

    const int64_t done = step + 1;
    if (average) average->update(done);
    const bool report = seconds() - last_report > 10 || done == options.steps;
    if (rank == 0 && (report || done % 20 == 0)) {
      const double per_second =
          static_cast<double>((done - reported_step) * options.batch) / std::max(1e-9, seconds() - reported_seconds);
      nlohmann::json line = {{"stage", task.name}, {"step", done}, {"seconds", seconds()}, {"rate", rate}};
      std::string text;
      for (const auto& [name, value] : losses) {
        const double v = value.item<double>();
        if (!std::isfinite(v))
          throw Error("training " + task.name, "loss " + name + " is not finite at step " + std::to_string(done));
        line["losses"][name] = v;
        text += fmt::format("  {} {:.5g}", name, v);
      }
      if (log) log << line.dump() << std::endl;
      if (report) {
        spdlog::info("{} {}/{}{}  {:.1f} samples/s  left {}", task.name, done, options.steps, text, per_second,
                     clock_text(static_cast<double>((options.steps - done) * options.batch) / per_second));
        last_report = reported_seconds = seconds();
        reported_step = done;
      }
    }
    if (rank == 0 && (done % options.validate_every == 0 || done == options.steps)) {
      torch::NoGradGuard no_grad;
      task.module->eval();
      if (average) average->swap();
      const double value = task.validate();
      if (value < result.best) {
        result.best = value;
        result.best_step = done;
        task.on_best();
      }
      if (average) average->swap();
      spdlog::info("{} {}/{}  validation {:.5g}  best {:.5g} at {}", task.name, done, options.steps, value, result.best,
                   result.best_step);
      if (log)
        log << nlohmann::json{{"stage", task.name}, {"step", done}, {"validation", value}, {"best", result.best}}.dump()
            << std::endl;
      last_report = reported_seconds = seconds();  // validation is not training time
      reported_step = done;
    }
    if (!ranks) stop_now = stop_requested != 0;  // also one that came while validating
    if (stop_now && done < options.steps) {
      save(done);
      if (rank == 0) spdlog::info("{} stopped at step {}; --resume goes on from there", task.name, done);
      result.interrupted = true;
      break;
    }
    if (done % options.checkpoint_every == 0 && done < options.steps) save(done);
  }
  if (next.valid()) next.wait();
  result.seconds = seconds();
  if (!result.interrupted && rank == 0) std::filesystem::remove(options.checkpoint);
  return result;
}

}  // namespace inhabit
