#include "inhabit/train/loop.h"

#include <spdlog/spdlog.h>

#include <omp.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <deque>
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
#include "inhabit/nn/batch_norm.h"
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
  const double risen = (progress + 1.0 / static_cast<double>(options.steps)) / std::max(options.schedule.warmup, 1e-9);
  const double floor = options.schedule.floor, cosine = 0.5 * (1 + std::cos(M_PI * progress));
  return options.learning_rate * std::min(1.0, risen) * (floor + (1 - floor) * cosine);
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

torch::optim::AdamW optimizer_of(const std::map<double, std::vector<torch::Tensor>>& groups, const TrainTask& task,
                                 const TrainOptions& options) {
  std::vector<torch::optim::OptimizerParamGroup> optimised;
  optimised.reserve(groups.size());
  for (const auto& [factor, parameters] : groups) optimised.emplace_back(parameters);
  return torch::optim::AdamW(std::move(optimised),
                             torch::optim::AdamWOptions(options.learning_rate).weight_decay(task.weight_decay));
}

/// One call of train(): what its steps share.
class TrainLoop {
 public:
  TrainLoop(const TrainTask& task, const TrainOptions& options)
      : task_(task),
        options_(options),
        rank_(options.ranks ? options.ranks->rank() : 0),
        rank_count_(options.ranks ? options.ranks->size() : 1),
        groups_(rate_groups(task)),
        optimizer_(optimizer_of(groups_, task, options)),
        order_(task.samples, options.batch * rank_count_, options.seed) {
    if (task.average > 0) average_.emplace(task.module, task.average);
    result_.best = std::numeric_limits<double>::infinity();
  }

  TrainResult run() {
    if (options_.resume) resume();
    std::optional<nn::SharedBatchNorms> shared;
    if (options_.ranks) {
      share_weights();
      shared.emplace(rank_count_, [this](std::vector<torch::Tensor>& each) { options_.ranks->average(each); });
    }
    const StopOnSignal stop;
    open_log();
    start_ = Clock::now();
    restart_report(first_step_);
    if (!options_.resume) save(0);  // so that a run that ends before its first checkpoint can be resumed too

    // Batches that are made ahead, the next one first. Where several are made at once, each has one thread.
    const int64_t ahead = task_.concurrent ? std::max<int64_t>(1, options_.workers) : 1;
    const auto prepared = [this, ahead](const TrainStep& step) {
      if (ahead > 1) omp_set_num_threads(1);
      return task_.prepare(step);
    };
    std::deque<std::future<std::function<Losses()>>> next;
    int64_t begun = first_step_;
    const auto begin_up_to = [&](int64_t end) {
      for (; begun < std::min(end, options_.steps); ++begun)
        next.push_back(std::async(std::launch::async, prepared, step_at(begun)));
    };
    begin_up_to(first_step_ + ahead);
    for (int64_t step = first_step_; step < options_.steps; ++step) {
      const std::function<Losses()> losses_of_batch = next.front().get();
      next.pop_front();
      begin_up_to(step + 1 + ahead);
      bool stop_now = false;
      const Losses losses = take(step, losses_of_batch, stop_now);
      const int64_t done = step + 1;
      if (average_) average_->update(done);
      if (rank_ == 0) {
        if (options_.progress) options_.progress(done, options_.steps);
        report(done, losses);
        if (done % options_.validate_every == 0 || done == options_.steps) validate(done);
      }
      if (!options_.ranks) stop_now = stop_requested != 0 || told_to_stop_;  // also one that came while validating
      if (stop_now && done < options_.steps) {
        save(done);
        if (rank_ == 0) spdlog::info("{} stopped at step {}; --resume goes on from there", task_.name, done);
        result_.interrupted = true;
        break;
      }
      if (done % options_.checkpoint_every == 0 && done < options_.steps) save(done);
    }
    for (const auto& batch : next) batch.wait();
    result_.seconds = seconds();
    if (!result_.interrupted && rank_ == 0) std::filesystem::remove(options_.checkpoint);
    return result_;
  }

 private:
  using Clock = std::chrono::steady_clock;

  /// What must be the same in a run that is resumed.
  std::string description() const {
    return fmt::format("{} steps {} batch {} rate {} samples {} seed {}{}{}", task_.name, options_.steps,
                       options_.batch * rank_count_, options_.learning_rate, task_.samples, options_.seed,
                       task_.settings.empty() ? "" : " ", task_.settings);
  }

  std::map<std::string, torch::Tensor>& averaged() { return average_ ? average_->weights() : no_average_; }

  double seconds() const { return seconds_before_ + std::chrono::duration<double>(Clock::now() - start_).count(); }

  void resume() {
    auto state = load_checkpoint(options_.checkpoint, *task_.module, optimizer_, averaged());
    if (state["run"] != description())
      throw Error(options_.checkpoint,
                  "belongs to another run (" + state["run"] + "; this one is " + description() + ")");
    const auto number = [&](const char* key) { return checkpoint_number(state, key, options_.checkpoint); };
    const auto step = [&](const char* key) {
      return static_cast<int64_t>(std::clamp(number(key), 0.0, static_cast<double>(options_.steps)));
    };
    first_step_ = step("step");
    seconds_before_ = number("seconds");
    result_.best = number("best");
    result_.best_step = step("best_step");
  }

  void save(int64_t step) {
    if (rank_ != 0) return;
    save_checkpoint(options_.checkpoint, *task_.module, optimizer_, averaged(),
                    {{"run", description()},
                     {"step", std::to_string(step)},
                     {"seconds", std::to_string(seconds())},
                     {"best", fmt::format("{}", result_.best)},
                     {"best_step", std::to_string(result_.best_step)}});
  }

  /// All ranks begin with the weights of the first.
  void share_weights() {
    std::vector<torch::Tensor> weights;
    for (const auto& p : task_.module->named_parameters()) weights.push_back(p.value().detach());
    for (const auto& b : task_.module->named_buffers()) weights.push_back(b.value());
    options_.ranks->broadcast(weights);
  }

  void open_log() {
    if (rank_ != 0 || options_.log.empty()) return;
    lock_.emplace(options_.log, "another training");
    log_.open(options_.log, options_.append_log ? std::ios::app : std::ios::trunc);
    if (!log_) throw Error(options_.log, "cannot be written");
  }

  /// A rank draws from seeds of its own; those of rank 0 are those of a run of one.
  uint64_t seed_of(uint64_t stream, int64_t step) const {
    const uint64_t seed = item_seed(options_.seed + stream, static_cast<uint64_t>(step));
    return rank_ == 0 ? seed : item_seed(seed, static_cast<uint64_t>(rank_));
  }

  /// On the loop's own thread alone: the order keeps the permutation of one epoch.
  TrainStep step_at(int64_t step) {
    const std::vector<int64_t> all = order_.indices(step);
    const auto first = all.begin() + rank_ * options_.batch;
    return {step, {first, first + options_.batch}, seed_of(1, step)};
  }

  /// One step of the optimiser. @param stop_now set where a rank is to stop.
  Losses take(int64_t step, const std::function<Losses()>& losses_of_batch, bool& stop_now) {
    const double rate = scheduled_rate(options_, step);
    for (auto [group, i] = std::pair(groups_.begin(), size_t{0}); group != groups_.end(); ++group, ++i)
      static_cast<torch::optim::AdamWOptions&>(optimizer_.param_groups()[i].options()).lr(rate * group->first);
    task_.module->train();
    torch::manual_seed(seed_of(2, step));  // of dropout
    optimizer_.zero_grad();
    Losses losses = losses_of_batch();
    losses.front().second.backward();
    stop_now = stop_requested != 0 || told_to_stop_;
    if (options_.ranks) stop_now = average_gradients(*task_.module, *options_.ranks, stop_now);
    torch::nn::utils::clip_grad_norm_(task_.module->parameters(), 1.0);
    optimizer_.step();
    return losses;
  }

  /// Losses go to the log every 20 steps, and to the terminal too every ten seconds and at the end.
  void report(int64_t done, const Losses& losses) {
    const bool aloud = seconds() - last_report_ > 10 || done == options_.steps;
    if (!aloud && done % 20 != 0) return;
    const int64_t batch = options_.batch * rank_count_;
    const double per_second =
        static_cast<double>((done - reported_step_) * batch) / std::max(1e-9, seconds() - reported_seconds_);
    nlohmann::json line = {
        {"stage", task_.name}, {"step", done}, {"seconds", seconds()}, {"rate", scheduled_rate(options_, done - 1)}};
    std::string text;
    for (const auto& [name, value] : losses) {
      const double v = value.item<double>();
      if (!std::isfinite(v))
        throw Error("training " + task_.name, "loss " + name + " is not finite at step " + std::to_string(done));
      line["losses"][name] = v;
      text += fmt::format("  {} {:.5g}", name, v);
    }
    if (log_) log_ << line.dump() << std::endl;
    if (options_.listener) {
      TrainReport heard{task_.name, done, options_.steps, seconds(), {}, 0, 0};
      for (const auto& [name, value] : losses) heard.losses.emplace_back(name, value.item<double>());
      tell(heard);
    }
    if (!aloud) return;
    spdlog::info("{} {}/{}{}  {:.1f} samples/s  left {}", task_.name, done, options_.steps, text, per_second,
                 clock_text(static_cast<double>((options_.steps - done) * batch) / per_second));
    restart_report(done);
    last_report_ = reported_seconds_;
  }

  void tell(const TrainReport& report) { told_to_stop_ = !options_.listener(report) || told_to_stop_; }

  void restart_report(int64_t done) {
    reported_seconds_ = seconds();
    reported_step_ = done;
  }

  void validate(int64_t done) {
    const torch::NoGradGuard no_grad;
    task_.module->eval();
    if (average_) average_->swap();
    const double value = task_.validate();
    if (value < result_.best || (options_.last && done == options_.steps)) {
      result_.best = value;
      result_.best_step = done;
      task_.on_best();
    }
    if (average_) average_->swap();
    spdlog::info("{} {}/{}  validation {:.5g}  best {:.5g} at {}", task_.name, done, options_.steps, value,
                 result_.best, result_.best_step);
    if (log_)
      log_
          << nlohmann::json{{"stage", task_.name}, {"step", done}, {"validation", value}, {"best", result_.best}}.dump()
          << std::endl;
    if (options_.listener) tell({task_.name, done, options_.steps, seconds(), {}, value, result_.best});
    restart_report(done);  // validation is not training time
    last_report_ = reported_seconds_;
  }

  const TrainTask& task_;
  const TrainOptions& options_;
  const int rank_, rank_count_;
  const std::map<double, std::vector<torch::Tensor>> groups_;  // by the factor of their learning rate
  torch::optim::AdamW optimizer_;
  Order order_;
  std::optional<WeightAverage> average_;
  std::map<std::string, torch::Tensor> no_average_;
  TrainResult result_;
  bool told_to_stop_ = false;  // by the listener
  int64_t first_step_ = 0;
  double seconds_before_ = 0;  // that a resumed run had taken
  Clock::time_point start_;
  std::ofstream log_;
  std::optional<FileLock> lock_;  // of the log: the files of weights are replaced by others at each writing
  double last_report_ = -1e9, reported_seconds_ = 0;
  int64_t reported_step_ = 0;
};

}  // namespace

TrainResult train(const TrainTask& task, const TrainOptions& options) {
  if (task.samples == 0) throw Error("the data set has no training window long enough for " + task.name);
  keep_freed_memory();
  return TrainLoop(task, options).run();
}

}  // namespace inhabit
