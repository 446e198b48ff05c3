#include "inhabit/inbetween/denoiser_task.h"

namespace inhabit::inbetween {

TrainTask denoiser_task(const Networks& networks, const TrainRun& run, int64_t samples) {
  TrainTask out;
  out.settings = to_json(networks.config) + (run.from.empty() ? "" : " from " + run.from);
  out.average = networks.config.training.average;
  out.weight_decay = networks.config.training.weight_decay;
  out.module = networks.network.ptr();
  out.networks = {{"net.", networks.network.ptr()}};
  out.samples = samples;
  out.concurrent = true;
  return out;
}

}  // namespace inhabit::inbetween
