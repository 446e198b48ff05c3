#pragma once
#include <functional>
#include <string>
#include <vector>

#include "inhabit/io/safetensors.h"
#include "inhabit/train/loop.h"

namespace inhabit {

/// Arguments of every system's training, beside its own configuration.
struct TrainRun {
  std::vector<std::string> data;        ///< data sets, as the system takes them
  std::string out;                      ///< model file; its best weights by validation are written as training goes on
  std::string from;                     ///< model file that weights start from; empty: at random
  std::vector<std::string> stages;      ///< names of those to run; empty: the system's usual ones
  bool resume = false;                  ///< goes on from the checkpoint of a run that was interrupted
  bool half = false;                    ///< weights are written in half precision
  uint64_t seed = 1;                    ///< of weights, batches and dropout
  torch::Device device = torch::kCPU;   ///< where the networks are trained
  std::shared_ptr<DataParallel> ranks;  ///< none: this process alone
  TrainListener listener;               ///< hears how it goes and may stop it; may be empty
  std::function<Progress(const std::string& stage)> progress;  ///< makes what hears a stage's steps; may be empty
  int64_t workers = 1;  ///< threads that make batches ahead; the numbers are the same with any number
  bool last = false;    ///< each stage ends with the weights of its last step, not with those that validated best
};

/// One stage: a network, or several that are trained together.
struct TrainStage {
  std::string name;                 ///< the task's
  int64_t steps = 0;                ///< updates of the weights
  int64_t batch = 0;                ///< samples of a step
  double learning_rate = 0;         ///< the schedule's peak
  RateSchedule schedule;            ///< of the learning rate
  int64_t validations = 12;         ///< evenly spread over the steps
  std::function<TrainTask()> task;  ///< makes the loop's task; called when the stage begins
};

/// A configuration's text, as the file `path` has it, with every setting of its system: what the text leaves out has
/// its default. Throws Error naming `path`.
using CompleteConfig = std::function<std::string(const std::string& text, const std::string& path)>;

/// The CompleteConfig of the system whose config_from_json this is.
template <class Config>
CompleteConfig completed_by(Config (*config_from_json)(const std::string& text, const std::string& subject)) {
  return [=](const std::string& text, const std::string& path) { return to_json(config_from_json(text, path)); };
}

/// Throws Error unless `asked` are among `stages` (all their names, in order); returns them in that order, or `usual`
/// where none is asked for.
std::vector<std::string> chosen_stages(const std::vector<std::string>& asked, const std::vector<std::string>& stages,
                                       const std::vector<std::string>& usual);

/// Trains stage by stage into one model file, run.out. The file holds `header` (system, configuration, and tensors that
/// belong to all networks) and the networks and tensors of each stage's task; it is written each time the stage
/// validates better. Networks of earlier stages, of this run or another, are kept. A run of several stages that is not
/// resumed begins the file anew. The log is `out`.log.jsonl; an interrupted run, whichever stage it was in, goes on
/// from `out`.checkpoint.safetensors. Returns false when it was interrupted. Throws Error where there is no checkpoint
/// to resume from or it is of another stage, or where the file holds networks of another configuration or header.
/// Configurations are compared as `complete` makes them, so that a setting the program has learned of since the file
/// was written has its default there.
bool run_stages(const std::vector<TrainStage>& stages, const SafeTensors& header, const TrainRun& run,
                const CompleteConfig& complete = {});

}  // namespace inhabit
