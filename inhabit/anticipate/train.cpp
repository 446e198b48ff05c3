#include "inhabit/anticipate/train.h"

#include <algorithm>
#include <filesystem>

#include "inhabit/anticipate/evaluate.h"
#include "inhabit/anticipate/futures.h"
#include "inhabit/anticipate/losses.h"
#include "inhabit/anticipate/on_cpu.h"
#include "inhabit/anticipate/plausibility_loss.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/anticipate/train_baselines.h"
#include "inhabit/anticipate/train_released.h"
#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/train/stages.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;
namespace F = torch::nn::functional;

// The reconstruction's errors are centimetres where the discriminators' losses are about 1.
constexpr double kPoseWeight = 40, kRootWeight = 1;
// In every batch some forecasts, two of each observation, run on without gradients for up to ten seconds before the
// discriminator sees them: the decoder must be stable on its own predictions for as long as users ask for, the
// discriminator must know such forecasts, and the two futures must differ by then (diversity loss).
constexpr int64_t kRuns = 16, kShortestRun = 20, kLongestRun = 250, kRunFrames = 30;
constexpr double kApart = 1.5;        // two futures differ enough at so many times the pose spread of the recording
constexpr int64_t kViews = 8;         // stretches of each sequence that the pose discriminator sees
constexpr int64_t kWords = 4;         // motion words of each forecast that are looked at for their plausibility
constexpr int64_t kFirstFrames = 10;  // the first of them begins in these

/// Ours with its discriminators, which live only while it is trained.
struct IntentionModelImpl : torch::nn::Module {
  explicit IntentionModelImpl(const Config& config) {
    intention = register_module("intention", IntentionNetwork(config));
    pose = register_module("pose", PoseNetwork(config));
    label_discriminator = register_module(
        "label_discriminator", Discriminator(config.future * config.labels, config.training.discriminator_hidden, 1));
    pose_discriminator = register_module(
        "pose_discriminator", Discriminator(2 * config.training.discriminator_frames * kFeatureCount + config.labels,
                                            config.training.discriminator_hidden, 2));
  }
  IntentionNetwork intention{nullptr};
  PoseNetwork pose{nullptr};
  Discriminator label_discriminator{nullptr}, pose_discriminator{nullptr};
};
TORCH_MODULE(IntentionModel);

/// What the pose discriminator sees: `frames` of x (B, T, F) from each of `starts` (B, V) on, their changes, and the
/// mean intention (B, T, C) meanwhile: (B V, D).
Tensor discriminator_views(const Tensor& x, const Tensor& intention, const Tensor& starts, int64_t frames) {
  const Tensor at = (starts.unsqueeze(2) + torch::arange(frames, starts.options())).flatten(1);  // (B, V frames)
  const auto gather = [&](const Tensor& all) {
    const Tensor picked = all.gather(1, at.unsqueeze(2).expand({-1, -1, all.size(2)}));
    return picked.view({-1, frames, all.size(2)});
  };
  const Tensor seen = gather(x);
  const Tensor change = (seen.slice(1, 1) - seen.slice(1, 0, -1)) * kVelocityScale;
  // The first frame's change is none of the stretch's.
  return torch::cat(
      {seen.flatten(1), torch::zeros_like(seen.select(1, 0)), change.flatten(1), gather(intention).mean(1)}, 1);
}

/// Windows as ours is trained on them.
struct IntentionBatch {
  Tensor frames;           // (B, observed + future, F) standardised
  Tensor labels;           // (B, T') int64 intentions
  Tensor weights;          // (B, future) 1 for frames that were recorded
  Tensor label_weights;    // (B, label_frames) likewise
  Tensor z, gumbel;        // noise of the forecasts (futures.h)
  Followed followed;       // standardised: what the forecasts follow,
  Followed run_followed;   // and those that run on
  Tensor real_starts;      // (B, V) where the pose discriminator looks at real motion,
  Tensor forecast_starts;  // (B, V) at the forecast, behind the frames before it,
  Tensor run_starts;       // (B, V) and at forecasts that ran on for
  int64_t run = 0;         // frames
  // On the CPU, where the words of recordings are.
  Tensor actions;                       // (B) int64
  Tensor word_starts, run_word_starts;  // (B, W) motion words of the forecasts, behind the frames before, and of those

  IntentionBatch on(torch::Device d) const {
    IntentionBatch out = *this;
    for (Tensor* tensor : {&out.frames, &out.labels, &out.weights, &out.label_weights, &out.z, &out.gumbel,
                           &out.real_starts, &out.forecast_starts, &out.run_starts})
      *tensor = tensor->to(d);
    out.followed = followed.on(d);
    out.run_followed = run_followed.on(d);
    return out;
  }
};

/// How many forecasts of a batch run on.
int64_t runs_of(int64_t batch) { return std::min<int64_t>(kRuns, batch) / 2 * 2; }

/// What forecasts of these windows follow: any recording but their own. Standardised.
Followed followed_by_windows(const Networks& n, const Tensor& frames, const std::vector<int64_t>& own,
                             const Tensor& choice) {
  if (!n.memory) return {};
  const Tensor past = frames.slice(1, n.config.observed - n.config.kappa, n.config.observed);
  return n.memory->follow(n.scale.from_network(past), choice, own).to_network(n.scale);
}

IntentionBatch intention_batch(const Data& data, const Networks& networks, const std::vector<int64_t>& indices,
                               uint64_t seed) {
  const Config& c = networks.config;
  std::mt19937_64 random(seed);
  const int64_t run = uniform_int(random, kShortestRun, kLongestRun);
  std::vector<Tensor> windows, labels, weights, label_weights, real, forecast, later, words, run_words;
  std::vector<int64_t> own, actions;
  const auto starts = [&](int64_t first, int64_t last, int64_t some = kViews) {
    std::vector<int64_t> out;
    for (int64_t v = 0; v < some; ++v)
      out.push_back(uniform_int(random, static_cast<int>(first), static_cast<int>(std::max(first, last))));
    return torch::tensor(out);
  };
  for (const int64_t index : indices) {
    const auto window = data.sample(index, chance(random, 0.5));
    windows.push_back(window.frames);
    own.push_back(window.recording);
    labels.push_back(window.labels);
    weights.push_back((torch::arange(c.observed, c.observed + c.future) < window.last).to(torch::kFloat32));
    label_weights.push_back(
        (torch::arange(c.observed, c.observed + c.training.label_frames) < window.last_label).to(torch::kFloat32));
    real.push_back(starts(window.first, window.last - c.training.discriminator_frames));
    forecast.push_back(starts(0, c.future - 1));  // with the frames before it, so that the first step is judged too
    later.push_back(starts(0, kRunFrames - c.training.discriminator_frames));
    actions.push_back(window.action);
    words.push_back(
        torch::cat({starts(0, std::min<int64_t>(kFirstFrames, c.future) - 1, 1), starts(0, c.future - 1, kWords - 1)}));
    run_words.push_back(starts(0, kRunFrames - c.kappa, kWords));
  }
  const auto count = static_cast<int64_t>(indices.size());
  const FutureNoise noise = draw_noise(c, count, std::max<int64_t>(c.future, run + kRunFrames), item_seed(seed, 1));
  const Tensor frames = torch::stack(windows);
  const int64_t runs = runs_of(count);
  std::vector<int64_t> run_own(own.begin(), own.begin() + runs / 2);
  run_own.insert(run_own.end(), own.begin(), own.begin() + runs / 2);
  return {frames,
          torch::stack(labels),
          torch::stack(weights),
          torch::stack(label_weights),
          noise.z,
          noise.gumbel,
          followed_by_windows(networks, frames, own, noise.choice.slice(1, 0, c.future + c.gamma - 1)),
          followed_by_windows(networks, frames.slice(0, 0, runs / 2).repeat({2, 1, 1}), run_own,
                              // backwards: other draws than the forecasts'
                              noise.choice.slice(0, 0, runs).slice(1, 0, run + kRunFrames + c.gamma - 1).flip(1)),
          torch::stack(real),
          torch::stack(forecast),
          torch::stack(later),
          run,
          torch::tensor(actions),
          torch::stack(words),
          torch::stack(run_words)};
}

Losses intention_losses(IntentionModel model, const IntentionBatch& b, const Config& c, const FeatureScale& scale,
                        const PlausibilityLoss& plausibility) {
  const Tensor past = b.frames.slice(1, 0, c.observed), truth = b.frames.slice(1, c.observed);
  const Tensor later_labels = F::one_hot(b.labels, c.labels).to(torch::kFloat32);
  const Tensor true_labels = later_labels.slice(1, 0, c.observed + c.future + c.gamma - 1);
  const auto unseen = [&](const Tensor& labels) { return c.intention ? labels : torch::zeros_like(labels); };
  const auto one_hot = [&](const Tensor& labels) { return F::one_hot(labels, c.labels).to(torch::kFloat32); };
  const Tensor ahead = true_labels.slice(1, c.observed);
  // The decoder sees the labels of what it follows, as in use; without a memory the true ones.
  const Tensor forecast_labels = c.memory ? one_hot(b.followed.labels) : ahead;
  PoseNetworkImpl::State state = model->pose->start(past, b.z);
  const Tensor forecast = model->pose->roll(state, forecast_labels, c.future, b.followed);
  const Tensor weights = b.weights * reconstruction_weights(c.future, c.training.rec_frames).to(b.weights.device());
  const Tensor rec = pose_reconstruction_loss(forecast, truth, weights, scale),
               root = root_reconstruction_loss(forecast, truth, weights);
  Tensor total = kPoseWeight * rec + kRootWeight * root;
  Losses losses = {{"rec", rec}, {"root", root}};
  if (c.intention) {
    const Tensor code = model->intention->encode(past);
    const int64_t end = c.observed + c.training.label_frames;
    const Tensor sym = intention_loss(model->intention->teacher_logits(code, later_labels.slice(1, c.observed, end)),
                                      b.labels.slice(1, c.observed, end).contiguous(), b.label_weights);
    total = total + sym;
    losses.emplace_back("intention", sym);
    if (c.training.label_discriminator) {
      const Tensor drawn = model->intention->draw(code, b.gumbel.slice(1, 0, c.future));
      add_discriminator(model->label_discriminator, "label", ahead.slice(1, 0, c.future).flatten(1), drawn.flatten(1),
                        c.training.label_discriminator_weight, total, losses);
    }
  }
  const auto behind = [&](int64_t context) { return torch::cat({past.slice(1, c.observed - context), forecast}, 1); };
  if (c.training.pose_discriminator || c.training.plausibility_weight > 0) {
    const int64_t run = b.run, runs = runs_of(past.size(0));
    const auto some = [&](const Tensor& all) { return all.slice(0, 0, runs); };
    const Tensor twice = past.slice(0, 0, runs / 2).repeat({2, 1, 1});
    Tensor labels = torch::zeros({runs, run + kRunFrames + c.gamma - 1, c.labels}, past.options());
    {
      const torch::NoGradGuard no_gradients;
      if (c.memory)
        labels = unseen(one_hot(b.run_followed.labels));
      else if (c.intention)
        labels = model->intention->draw(model->intention->encode(twice),
                                        some(b.gumbel).slice(1, 0, run + kRunFrames + c.gamma - 1));
      state = model->pose->start(twice, some(b.z));
      model->pose->roll(state, labels, run, b.run_followed);
    }
    const Tensor later = labels.slice(1, run);
    const Tensor last = model->pose->roll(state, later, kRunFrames, b.run_followed.from(run));
    const Tensor sameness = diversity_loss(last.slice(0, 0, runs / 2), last.slice(0, runs / 2), scale,
                                           kApart * pose_spread(b.frames.slice(0, 0, runs / 2), scale));
    total = total + c.training.diversity_weight * sameness;
    losses.emplace_back("sameness", sameness);
    if (c.training.pose_discriminator) {
      const int64_t frames = c.training.discriminator_frames, context = frames - 1;
      const Tensor labels_behind =
          torch::cat({true_labels.slice(1, c.observed - context, c.observed), forecast_labels}, 1);
      const Tensor views = discriminator_views(behind(context), unseen(labels_behind), b.forecast_starts, frames),
                   run_views = discriminator_views(last, later, some(b.run_starts), frames);
      add_discriminator(model->pose_discriminator, "pose",
                        discriminator_views(b.frames, unseen(true_labels), b.real_starts, frames),
                        torch::cat({views, run_views}), c.training.pose_discriminator_weight, total, losses);
    }
    if (c.training.plausibility_weight > 0) {
      const Tensor soon = plausibility(scale.from_network(behind(c.kappa - 1)).cpu(), b.actions, b.word_starts);
      const Tensor late = plausibility(scale.from_network(last).cpu(),
                                       some(b.actions).slice(0, 0, runs / 2).repeat({2}), some(b.run_word_starts));
      total = total + c.training.plausibility_weight * (soon + late).to(total.device());
      losses.emplace_back("implausible", soon);
      losses.emplace_back("implausible_later", late);
    }
  }
  losses.insert(losses.begin(), {"total", total});
  return losses;
}

TrainTask intention_task(Networks& networks, const Data& data, const std::vector<Sequence>& recordings,
                         const std::vector<Sequence>& validation, torch::Device device) {
  const Config& c = networks.config;
  if (c.released)
    return released_task(
        networks, data,
        [&, device] {
          const OnCpu moved(device, {networks.released_pose.ptr(), networks.released_intention.ptr()});
          return 1 - validation_ndms(networks, validation);
        },
        device);
  IntentionModel model(c);
  const auto plausibility = std::make_shared<const PlausibilityLoss>(recordings, c.kappa);
  networks.intention = model->intention;
  networks.pose = model->pose;
  if (!c.intention) networks.intention = nullptr;
  TrainTask task;
  task.average = c.training.average;
  task.rate_factor = faster_discriminators;
  task.module = model.ptr();
  task.networks = {{"pose_net.", networks.pose.ptr()}};
  if (c.intention) task.networks["intention_net."] = networks.intention.ptr();
  task.tensors = cluster_tensors(networks.clusters);
  if (networks.memory) {
    // What is used remembers the validation recordings too; what is validated does not.
    std::vector<Sequence> all = recordings;
    all.insert(all.end(), validation.begin(), validation.end());
    std::vector<Remembered> kept = remembered_motion(all, c.kappa);
    for (size_t i = recordings.size(); i < kept.size(); ++i) kept[i].validation = true;
    task.tensors.merge(memory_tensors(kept));
  }
  task.samples = data.size();
  task.prepare = batches(
      [&](const TrainStep& step) { return intention_batch(data, networks, step.indices, step.seed); },
      [&, model, device, scale = networks.scale.to(device), plausibility](const IntentionBatch& b, const TrainStep&) {
        return intention_losses(model, b.on(device), c, scale, *plausibility);
      });
  task.validate = [&, device] {
    const OnCpu moved(device, {networks.pose.ptr(), c.intention ? networks.intention.ptr() : nullptr});
    return 1 - validation_ndms(networks, validation);
  };
  return task;
}

}  // namespace

bool train(const TrainRun& run, const Config& config, Notes* notes) {
  validate(config, run.out);
  const std::vector<std::string> names =
      chosen_stages(run.stages, {"intention", "seq2seq", "ltd", "hisrep", "vae", "dlow", "mix_match", "grammar"},
                    {"intention", "seq2seq", "ltd", "hisrep"});
  const auto is_asked = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  if (is_asked("dlow") && !is_asked("vae") && names.size() > 1)
    throw Error("stage 'dlow'",
                "is trained alone, or with vae: with others the model file, which holds its VAE, is begun anew");
  for (const char* stochastic : {"vae", "dlow", "mix_match", "grammar"})
    if (config.released && is_asked(stochastic))
      throw Error(std::string("stage '") + stochastic + "'", "is of preset compact, whose features are standardised");
  const Config::Baselines& b = config.baselines;
  if (is_asked("hisrep")) {
    if (b.hisrep_query + b.hisrep_future > config.observed)
      throw Error("baselines.hisrep_query", "and hisrep_future are longer together than what is observed");
    if (b.hisrep_future > config.future) throw Error("baselines.hisrep_future", "is longer than what is forecast");
  }
  if (run.data.size() != 1) throw Error("data", "is one folder here, not " + std::to_string(run.data.size()));
  if (!run.from.empty()) throw Error("from", "is not for anticipation: a run starts at random");
  const std::string& source = run.data.front();
  std::vector<ActionMotion> motions = read_motion_set(source, kDatabaseStride * config.rate, notes);
  if (config.training.folds > 0) motions = left_out_fold(motions, config.training.folds, config.training.fold);

  Networks networks;
  networks.config = config;
  networks.skeleton = training_skeleton(motions, source);
  const auto train_sequences = sequences_of(motions, "train", networks.skeleton, config.rate),
             validation = sequences_of(motions, "val", networks.skeleton, config.rate);
  if (test_windows(validation, config, 1).empty())
    throw Error(source, "has no validation recording that is long enough");
  std::vector<Tensor> features;
  for (const Sequence& s : train_sequences)
    for (const Tensor& f : {s.features, mirrored_features(s.features)}) features.push_back(f);
  networks.scale = feature_scale(torch::cat(features));
  if (config.released)  // the authors' poses are metres
    networks.scale = {torch::zeros({kFeatureCount}), torch::ones({kFeatureCount})};
  networks.clusters = cluster_recordings(train_sequences, config, run.seed);
  if (config.memory && !config.released && is_asked("intention"))
    networks.memory = make_memory(remembered_motion(train_sequences, config.kappa), networks.clusters, config, source);
  const Data data(train_sequences, networks);

  std::vector<TrainStage> stages;
  for (const std::string& name : names) {
    const bool ours = name == "intention";
    stages.push_back({name, ours ? config.training.steps : config.baselines.steps,
                      name == "dlow" ? config.baselines.dlow_batch : config.training.batch,
                      ours ? config.training.learning_rate : config.baselines.learning_rate, config.training.schedule,
                      20, [&, name] {
                        return name == "intention"
                                   ? intention_task(networks, data, train_sequences, validation, run.device)
                                   : baseline_task(name, networks, data, validation, run);
                      }});
  }
  return run_stages(stages, model_header(config, networks.skeleton, networks.scale), run,
                    completed_by(config_from_json));
}

}  // namespace inhabit::anticipate
