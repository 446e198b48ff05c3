#include "inhabit/interact/train_frames.h"

#include "inhabit/error.h"
#include "inhabit/interact/losses.h"
#include "inhabit/interact/rollout.h"

namespace inhabit::interact {
namespace {

constexpr int64_t kValidationRows = 2048;
constexpr double kLost = 2;  // deviations: farther off, a rollout has got lost

/// Rows as a predictor takes them, standardised.
struct PoseBatch {
  torch::Tensor input, target;
};

/// What a predictor sees, standardised where it is trained.
torch::Tensor network_input(const Training& t, Predictor predictor, const torch::Tensor& input,
                            const torch::Tensor& contacts) {
  return rows_for(predictor, input_layout(t.model.config), t.input.to(t.device).to_network(input.to(t.device)),
                  contacts.to(t.device));
}

PoseBatch standardised(const Training& t, Predictor predictor, const PoseRows& rows) {
  const torch::NoGradGuard no_grad;
  return {network_input(t, predictor, rows.input, rows.contacts),
          t.output.to(t.device).to_network(rows.target.to(t.device))};
}

/// For each sample of a step, drawn from its seed.
std::vector<SenseNoise> noise_of(const Config& config, const TrainStep& step) {
  std::vector<SenseNoise> out;
  if (config.training.sense_noise == 0) return out;
  std::mt19937_64 random(step.seed);
  const InputLayout layout = input_layout(config);
  out.reserve(step.indices.size());
  for (size_t i = 0; i < step.indices.size(); ++i)
    out.emplace_back(layout, config, config.training.sense_noise, random);
  return out;
}

/// A network that predicts frames, as it is trained.
struct FrameModel {
  Predictor predictor;
  std::shared_ptr<torch::nn::Module> module;
  std::function<torch::Tensor(const torch::Tensor& input)> predict;  ///< standardised rows, in evaluation mode
  /// @param reconstruction the error of predicted frames, a mean over them.
  using Error = std::function<torch::Tensor(const torch::Tensor& output, const torch::Tensor& target)>;
  std::function<Losses(const PoseBatch& batch, const Error& reconstruction)> losses;
};

FrameModel frame_model(Predictor predictor, PoseNetwork network) {
  return {predictor, network.ptr(), [network](const torch::Tensor& x) mutable { return network->forward(x); },
          [network](const PoseBatch& b, const FrameModel::Error& error) mutable {
            return Losses{{"square", error(network->forward(b.input), b.target)}};
          }};
}

FrameModel frame_model(Predictor predictor, SampNetwork network, double beta) {
  return {predictor, network.ptr(),
          [network](const torch::Tensor& x) mutable {
            return network->decode(torch::randn({x.size(0), network->z}, x.options()), x);
          },
          [network, beta](const PoseBatch& b, const FrameModel::Error& error) mutable {
            const nn::LatentDistribution z = network->encode(b.target, b.input);
            const torch::Tensor noise = network->is_training() ? torch::randn_like(z.mean) : torch::zeros_like(z.mean);
            const torch::Tensor square = error(network->decode(z.sample(noise), b.input), b.target);
            const torch::Tensor divergence = z.divergence();
            return Losses{{"total", square + beta * divergence}, {"square", square}, {"divergence", divergence}};
          }};
}

TrainTask plain_task(const Training& t, const FrameModel& model) {
  TrainTask task;
  task.module = model.module;
  task.networks = {{name_of(model.predictor) + "_net.", model.module}};
  task.samples = t.data.poses();
  task.concurrent = true;
  task.weight_decay = t.model.config.training.pose_decay;
  return task;
}

/// On single frames of recordings.
TrainTask step_task(const Training& t, const FrameModel& model) {
  TrainTask task = plain_task(t, model);
  const auto rows_of = [&t, model](const Data& data, const std::vector<int64_t>& indices,
                                   const std::vector<SenseNoise>& noise) {
    const PoseRows rows = data.pose_rows(indices);
    for (size_t i = 0; i < noise.size(); ++i)
      noise[i].apply(rows.input.data_ptr<float>() + static_cast<int64_t>(i) * rows.input.size(1));
    return standardised(t, model.predictor, rows);
  };
  const FrameModel::Error square = [](const auto& output, const auto& target) {
    return torch::mse_loss(output, target);
  };
  task.prepare = batches(
      [&t, rows_of](const TrainStep& step) { return rows_of(t.data, step.indices, noise_of(t.model.config, step)); },
      [model, square](const PoseBatch& b, const TrainStep&) { return model.losses(b, square); });
  task.validate = [&t, model, rows_of, square] {
    return validated(t.validation.poses(), kValidationRows, [&](const std::vector<int64_t>& some) {
      return model.losses(rows_of(t.validation, some, {}), square).front().second.template item<double>();
    });
  };
  return task;
}

/// On rows of its own rollouts.
TrainTask rollout_task(const Training& t, const FrameModel& model) {
  const Config::Training& settings = t.model.config.training;
  const auto rows_of = [&t, model, &settings](const Data& data, const std::vector<int64_t>& indices,
                                              const std::vector<SenseNoise>& noise) {
    const torch::NoGradGuard no_grad;
    const bool training = model.module->is_training();
    model.module->eval();
    const PoseFunction predict = [&](const torch::Tensor& input, const torch::Tensor& contacts) {
      return t.output.from_network(model.predict(network_input(t, model.predictor, input, contacts)).cpu());
    };
    const PoseRows rows = rollout(data, indices, settings.rollout_frames, predict, noise);
    model.module->train(training);
    return standardised(t, model.predictor, rows);
  };
  const FrameModel::Error error = [out = output_layout(t.model.config), &settings](const auto& output,
                                                                                   const auto& target) {
    return frame_loss(out, output, target, settings.rollout_hand_weight, kLost);
  };
  TrainTask task = plain_task(t, model);
  task.average = settings.rollout_average;
  // Rollouts are made with the weights of the step that learns from them, on its own thread.
  task.prepare = batches([](const TrainStep& step) { return step.indices; },
                         [model, rows_of, error, &t](const std::vector<int64_t>& indices, const TrainStep& step) {
                           return model.losses(rows_of(t.data, indices, noise_of(t.model.config, step)), error);
                         });
  task.validate = [model, rows_of, error, &t, &settings] {
    return validated(
        t.validation.poses(), kValidationRows / settings.rollout_frames, [&](const std::vector<int64_t>& some) {
          return model.losses(rows_of(t.validation, some, {}), error).front().second.template item<double>();
        });
  };
  return task;
}

/// The network of a stage that trains on frames: a new one, or the one that a run starts from. Rollouts go on from the
/// stage before them, or from --from.
template <class Network, class Make>
Network frame_network(Network& here, const Network& start, Predictor predictor, bool rollouts, const std::string& from,
                      const Make& make) {
  if (!rollouts || here.is_empty()) {
    if (rollouts && start.is_empty())
      throw Error("stage " + rollout_stage(predictor),
                  "goes on from a network: train stage " + name_of(predictor) + " first, or say --from");
    here = begun(start, name_of(predictor) + "_net.", from, make);
  }
  return here;
}

}  // namespace

std::string rollout_stage(Predictor predictor) {
  return predictor == Predictor::pose ? "rollout" : name_of(predictor) + "_rollout";
}

double validated(int64_t size, int64_t count, const std::function<double(const std::vector<int64_t>&)>& error) {
  const std::vector<int64_t> rows = spread_indices(size, count);
  constexpr size_t kTogether = 128;
  double sum = 0;
  for (size_t first = 0; first < rows.size(); first += kTogether) {
    const size_t end = std::min(first + kTogether, rows.size());
    sum += static_cast<double>(end - first) *
           error({rows.begin() + static_cast<long>(first), rows.begin() + static_cast<long>(end)});
  }
  return sum / static_cast<double>(rows.size());
}

TrainTask frame_task(Predictor predictor, bool rollouts, Training& t, const Networks& start, const std::string& from) {
  Networks& m = t.model;
  const Config& c = m.config;
  const auto like_pose = [&](PoseNetwork& here, const PoseNetwork& first, const PoseSizes& sizes) {
    return frame_model(predictor,
                       frame_network(here, first, predictor, rollouts, from, [&] { return PoseNetwork(sizes); }));
  };
  const auto like_samp = [&](SampNetwork& here, const SampNetwork& first, bool contacts) {
    return frame_model(predictor,
                       frame_network(here, first, predictor, rollouts, from, [&] { return SampNetwork(c, contacts); }),
                       c.baselines.samp_beta);
  };
  const FrameModel model = predictor == Predictor::nsm ? like_pose(m.nsm, start.nsm, nsm_sizes(c, false))
                           : predictor == Predictor::nsm_control
                               ? like_pose(m.nsm_control, start.nsm_control, nsm_sizes(c, true))
                           : predictor == Predictor::samp         ? like_samp(m.samp, start.samp, false)
                           : predictor == Predictor::samp_control ? like_samp(m.samp_control, start.samp_control, true)
                                                                  : like_pose(m.pose, start.pose, pose_sizes(c));
  model.module->to(t.device);
  return rollouts ? rollout_task(t, model) : step_task(t, model);
}

}  // namespace inhabit::interact
