#pragma once
#include <torch/torch.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "inhabit/progress.h"
#include "inhabit/train/data_parallel.h"
#include "inhabit/train/rate_schedule.h"

namespace inhabit {

/// Named scalar losses; the first is the one that is minimised.
using Losses = std::vector<std::pair<std::string, torch::Tensor>>;

/// How a training goes: its losses every 20 steps, or a validation.
struct TrainReport {
  std::string stage;                                   ///< TrainTask::name
  int64_t step = 0;                                    ///< steps done
  int64_t steps = 0;                                   ///< in all
  double seconds = 0;                                  ///< of this run and the ones it resumed
  std::vector<std::pair<std::string, double>> losses;  ///< empty: a validation
  double validation = 0;                               ///< of a validation: its value
  double best = 0;                                     ///< of a validation: the lowest so far
};
/// Called in the loop's thread; false stops the training as SIGINT does.
using TrainListener = std::function<bool(const TrainReport&)>;

/// A step of a training, passed to the functions that make its batch and its losses.
struct TrainStep {
  int64_t number = 0;            ///< 0 is the first
  std::vector<int64_t> indices;  ///< samples of the batch
  uint64_t seed = 0;             ///< of whatever is random in it
};

/// What a system gives the loop.
struct TrainTask {
  std::string name;                           ///< of the stage, in logs and checkpoints
  std::string settings;                       ///< what else a resumed run must agree on
  std::shared_ptr<torch::nn::Module> module;  ///< whose parameters are trained
  int64_t samples = 0;                        ///< in an epoch
  /// Makes a step's batch and returns what computes the losses of it (see `batches`). Runs on another thread, steps
  /// ahead, and must depend on its argument alone; what it returns runs on the loop's own thread.
  std::function<std::function<Losses()>(const TrainStep& step)> prepare;
  bool concurrent = false;           ///< `prepare` may run for several steps at once
  std::function<double()> validate;  ///< lower is better; the module is in eval mode and no gradients are kept
  std::function<void()> on_best;     ///< called with the weights that validated best so far
  /// What the learning rate is multiplied with for a parameter of this name; unset: 1.
  std::function<double(const std::string& name)> rate_factor;
  double weight_decay = 0;  ///< AdamW's
  double average = 0;       ///< decay of a moving average of the weights (EMA), which then is what validates; 0: none

  /// What is written to the model file (train/stages.h): networks by the prefix of their parameters, and tensors.
  std::map<std::string, std::shared_ptr<torch::nn::Module>> networks;
  std::map<std::string, torch::Tensor> tensors;  ///< that are no weights: means, deviations
  std::vector<std::string> outdated;  ///< prefixes of networks of the file that no longer fit those of this task
};

/// TrainTask::prepare from two functions that share a batch of a type of their own: `make_batch(step)`, which runs
/// ahead, and `losses_of(batch, step)`.
template <class MakeBatch, class LossesOf>
auto batches(MakeBatch make_batch, LossesOf losses_of) {
  return [make_batch, losses_of](const TrainStep& step) mutable -> std::function<Losses()> {
    auto batch =
        std::make_shared<const std::decay_t<std::invoke_result_t<MakeBatch&, const TrainStep&>>>(make_batch(step));
    return [batch, step, losses_of]() mutable { return losses_of(*batch, step); };
  };
}

/// How the loop runs.
struct TrainOptions {
  int64_t steps = 1000;                 ///< updates of the weights
  int64_t batch = 8;                    ///< samples of a step; of each rank, where there are several
  double learning_rate = 1e-3;          ///< the schedule's peak
  RateSchedule schedule;                ///< of the learning rate
  int64_t validate_every = 500;         ///< steps; the last step always validates
  int64_t checkpoint_every = 200;       ///< steps
  uint64_t seed = 1;                    ///< of epochs, batches and dropout
  bool resume = false;                  ///< goes on from `checkpoint`
  std::string checkpoint;               ///< file, written atomically; removed when the run completes
  std::string log;                      ///< JSON lines
  bool append_log = false;              ///< append to an existing log
  std::shared_ptr<DataParallel> ranks;  ///< the processes that train together; none: this one alone
  TrainListener listener;               ///< may be empty; of the process of rank 0
  Progress progress;                    ///< hears of every step; may be empty; of the process of rank 0
  int64_t workers = 1;                  ///< threads that make batches ahead, where the task is `concurrent`
  bool last = false;                    ///< the weights of the last step count as the best, whatever their validation
};

/// How a training ended.
struct TrainResult {
  double best = 0;           ///< lowest validation value; with TrainOptions::last the last one
  int64_t best_step = 0;     ///< steps done when it was reached
  double seconds = 0;        ///< of this run and the ones it resumed
  bool interrupted = false;  ///< SIGINT or SIGTERM came, or the listener said so: the checkpoint holds everything
};

/// AdamW with a cosine schedule after a linear warm-up. Every epoch is a permutation drawn from (seed, epoch), every
/// batch is prepared from (seed, step) and dropout draws from them, so that a resumed run gives the same numbers as one
/// that was never interrupted. With several ranks each takes its part of a step's samples, and gradients are averaged
/// as if one rank had the whole batch; rank 0 validates, logs and writes. Throws Error when the loss stops being
/// finite, or when `resume` finds no checkpoint or one of another run.
TrainResult train(const TrainTask& task, const TrainOptions& options);

}  // namespace inhabit
