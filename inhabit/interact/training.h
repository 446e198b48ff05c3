#pragma once
#include <functional>
#include <string>
#include <vector>

#include "inhabit/interact/model_file.h"
#include "inhabit/interact/sample.h"
#include "inhabit/nn/parameters.h"
#include "inhabit/train/stages.h"

namespace inhabit::interact {

/// What the stages of a run share.
struct Training {
  /// Reads the data. A constructor: as an aggregate, GCC 12 freed what it had so far twice when the data could not be
  /// read.
  Training(const TrainRun& run, const Config& config)
      : data(run.data, "train", config, config.training.mirrored),
        validation(run.data, "val", config, false),
        device(run.device) {}

  Networks model;        ///< what the run starts from and has so far
  Data data;             ///< of the split that is trained on
  Data validation;       ///< of the one that is validated on
  torch::Device device;  ///< where networks are trained
  FeatureScale input;    ///< of PoseNet's rows, on the CPU
  FeatureScale output;   ///< of what comes out, on the CPU
};

/// The mean over at most `count` of `size` samples, evenly spread, of what `error` says of some of them.
double validated(int64_t size, int64_t count, const std::function<double(const std::vector<int64_t>&)>& error);

/// A network, or the one that a run starts from.
template <class Network, class Make>
Network begun(const Network& start, const std::string& prefix, const std::string& file, const Make& make) {
  Network network = make();
  if (start.is_empty()) return network;
  SafeTensors content;
  nn::collect_parameters(*start, prefix, content);
  nn::load_parameters(*network, prefix, content, file);
  network->train();
  return network;
}

}  // namespace inhabit::interact
