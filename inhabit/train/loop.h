#pragma once
#include <torch/torch.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace inhabit {

/// Tensors of one batch, in an order the task knows.
using Batch = std::vector<torch::Tensor>;
/// Named scalar losses; the first is the one that is minimised.
using Losses = std::vector<std::pair<std::string, torch::Tensor>>;

/// What a system tells the loop. `prepare` runs on another thread, one batch ahead, and must depend on its arguments
/// alone.
struct TrainTask {
  std::string name;
  std::string settings;  ///< what else a resumed run must agree on
  std::shared_ptr<torch::nn::Module> module;
  int64_t samples = 0;
  std::function<Batch(const std::vector<int64_t>& indices, uint64_t seed)> prepare;
  std::function<Losses(const Batch& batch)> losses;
  std::function<double()> validate;  ///< lower is better; the module is in eval mode and no gradients are kept
  std::function<void()> on_best;     ///< called with the weights that validated best so far
  /// What the learning rate is multiplied with for a parameter of this name; unset: 1.
  std::function<double(const std::string& name)> rate_factor;
  double weight_decay = 0;  ///< decoupled from the gradients (AdamW): each step shrinks weights by rate times this
  double average = 0;       ///< decay of a moving average of the weights (EMA), which then is what validates;
                            ///< 0: none
};

struct TrainOptions {
  int64_t steps = 1000;
  int64_t batch = 8;
  double learning_rate = 1e-3;
  int64_t validate_every = 500;    ///< steps; the last step always validates
  int64_t checkpoint_every = 200;  ///< steps
  uint64_t seed = 1;
  bool resume = false;
  std::string checkpoint;   ///< file, written atomically; removed when the run completes
  std::string log;          ///< JSON lines
  bool append_log = false;  ///< go on in a log that is there
};

struct TrainResult {
  double best = 0;  ///< lowest validation value
  int64_t best_step = 0;
  double seconds = 0;        ///< of this run and the ones it resumed
  bool interrupted = false;  ///< SIGINT or SIGTERM came: the checkpoint holds everything
};

/// Adam with a cosine schedule (5 % warm-up, down to 2 % of the rate). Every epoch is a permutation drawn from (seed,
/// epoch), every batch is prepared from (seed, step) and dropout draws from them, so that a resumed run gives the same
/// numbers as one that was never interrupted. Throws Error when the loss stops being finite, or when `resume` finds no
/// checkpoint or one of another run.
TrainResult train(const TrainTask& task, const TrainOptions& options);

}  // namespace inhabit
