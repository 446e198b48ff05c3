#include "inhabit/anticipate/train.h"

#include <filesystem>

#include "inhabit/anticipate/evaluate.h"
#include "inhabit/anticipate/futures.h"
#include "inhabit/anticipate/losses.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/train/stages.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;
namespace F = torch::nn::functional;

// The reconstruction's errors are centimetres where the adversaries' losses are about 1.
constexpr double kPoseWeight = 40, kRootWeight = 1;
// With every batch some of its forecasts, two of an observation, run on without gradients for up to ten seconds before
// they are judged: the decoder must stand on its own predictions for as long as users ask for, the adversary must know
// what they look like then, and the two must have parted.
constexpr int64_t kRuns = 16, kShortestRun = 20, kLongestRun = 250, kRunFrames = 30;
constexpr double kApart = 1.5;  // two futures have parted that differ so much more than two poses of the recording do
constexpr int64_t kViews = 8;   // stretches of each sequence that the pose adversary sees
constexpr double kVelocityScale = 5;       // standardised poses change by some 0.2 a frame
constexpr double kGradientPenalty = 0.05;  // keeps the adversary from cutting real from forecast too sharply (R1)

/// Ours with its adversaries, which live only while it is trained.
struct IntentionModelImpl : torch::nn::Module {
  explicit IntentionModelImpl(const Config& config) {
    intention = register_module("intention", IntentionNetwork(config));
    pose = register_module("pose", PoseNetwork(config));
    label_adversary =
        register_module("label_adversary", Discriminator(config.future * config.labels, config.adversary_hidden, 1));
    pose_adversary = register_module(
        "pose_adversary",
        Discriminator(2 * config.adversary_frames * kFeatureCount + config.labels, config.adversary_hidden, 2));
  }
  IntentionNetwork intention{nullptr};
  PoseNetwork pose{nullptr};
  Discriminator label_adversary{nullptr}, pose_adversary{nullptr};
};
TORCH_MODULE(IntentionModel);

/// What the pose adversary sees: `frames` of x (B, T, F) from each of `starts` (B, V) on, their changes, and the mean
/// intention (B, T, C) meanwhile: (B V, D).
Tensor adversary_views(const Tensor& x, const Tensor& intention, const Tensor& starts, int64_t frames) {
  const Tensor at = (starts.unsqueeze(2) + torch::arange(frames)).flatten(1);  // (B, V frames)
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

void let_learn(torch::nn::Module& module, bool learn) {
  for (Tensor& p : module.parameters()) p.set_requires_grad(learn);
}

/// Adds to `total` what one adversary and the forecast it judges lessen; named for the log.
void add_adversary(Discriminator adversary, const std::string& name, const Tensor& real, const Tensor& forecast,
                   double weight, Tensor& total, Losses& losses) {
  if (forecast.requires_grad()) {
    let_learn(*adversary, false);
    const Tensor deception = generator_loss(adversary->forward(forecast));
    let_learn(*adversary, true);
    total = total + weight * deception;
    losses.emplace_back(name + "_deception", deception);
  }
  const Tensor seen = real.detach().clone().requires_grad_(torch::GradMode::is_enabled());
  const Tensor logits = adversary->forward(seen);
  const Tensor judged = discriminator_loss(logits, adversary->forward(forecast.detach()));
  total = total + judged;
  if (torch::GradMode::is_enabled()) {
    const Tensor slope = torch::autograd::grad({logits.sum()}, {seen}, {}, true, /*create_graph=*/true)[0];
    total = total + 0.5 * kGradientPenalty * slope.square().sum(1).mean();
  }
  losses.emplace_back(name + "_adversary", judged);
}

// Places in a batch of ours.
enum : size_t {
  kFrames,
  kLabels,
  kWeights,
  kLabelWeights,
  kZ,
  kGumbel,
  kRealStarts,
  kForecastStarts,
  kRunStarts,
  kRun
};

Batch intention_batch(const Data& data, const Config& c, const std::vector<int64_t>& indices, uint64_t seed) {
  std::mt19937_64 random(seed);
  const int64_t run = uniform_int(random, kShortestRun, kLongestRun);
  std::vector<Tensor> windows, labels, weights, label_weights, real, forecast, later;
  const auto starts = [&](int64_t first, int64_t last) {
    std::vector<int64_t> out;
    for (int64_t v = 0; v < kViews; ++v)
      out.push_back(uniform_int(random, static_cast<int>(first), static_cast<int>(std::max(first, last))));
    return torch::tensor(out);
  };
  for (const int64_t index : indices) {
    const auto window = data.sample(index, chance(random, 0.5));
    windows.push_back(window.frames);
    labels.push_back(window.labels);
    weights.push_back((torch::arange(c.observed, c.observed + c.future) < window.last).to(torch::kFloat32));
    label_weights.push_back(
        (torch::arange(c.observed, c.observed + c.label_frames) < window.last_label).to(torch::kFloat32));
    real.push_back(starts(window.first, window.last - c.adversary_frames));
    forecast.push_back(starts(0, c.future - 1));  // with the frames before it, so that the first step is judged too
    later.push_back(starts(0, kRunFrames - c.adversary_frames));
  }
  const auto count = static_cast<int64_t>(indices.size());
  const FutureNoise noise = draw_noise(c, count, std::max<int64_t>(c.future, run + kRunFrames), item_seed(seed, 1));
  return {torch::stack(windows),
          torch::stack(labels),
          torch::stack(weights),
          torch::stack(label_weights),
          noise.z,
          noise.gumbel,
          torch::stack(real),
          torch::stack(forecast),
          torch::stack(later),
          torch::tensor(run)};
}

Losses intention_losses(IntentionModel model, const Batch& b, const Config& c, const FeatureScale& scale) {
  const Tensor past = b[kFrames].slice(1, 0, c.observed), truth = b[kFrames].slice(1, c.observed);
  const Tensor later_labels = F::one_hot(b[kLabels], c.labels).to(torch::kFloat32);
  const Tensor true_labels = later_labels.slice(1, 0, c.observed + c.future + c.gamma - 1);
  const auto unseen = [&](const Tensor& labels) { return c.intention ? labels : torch::zeros_like(labels); };
  const Tensor ahead = true_labels.slice(1, c.observed);
  PoseNetworkImpl::State state = model->pose->start(past, b[kZ]);
  const Tensor forecast = model->pose->roll(state, ahead, c.future);
  const Tensor weights = b[kWeights] * reconstruction_weights(c.future, c.rec_frames);
  const Tensor rec = pose_reconstruction_loss(forecast, truth, weights, scale),
               root = root_reconstruction_loss(forecast, truth, weights);
  Tensor total = kPoseWeight * rec + kRootWeight * root;
  Losses losses = {{"rec", rec}, {"root", root}};
  if (c.intention) {
    const Tensor code = model->intention->encode(past);
    const int64_t end = c.observed + c.label_frames;
    const Tensor sym = intention_loss(model->intention->teacher_logits(code, later_labels.slice(1, c.observed, end)),
                                      b[kLabels].slice(1, c.observed, end).contiguous(), b[kLabelWeights]);
    total = total + sym;
    losses.emplace_back("intention", sym);
    if (c.label_adversary) {
      const Tensor drawn = model->intention->draw(code, b[kGumbel].slice(1, 0, c.future));
      add_adversary(model->label_adversary, "label", ahead.slice(1, 0, c.future).flatten(1), drawn.flatten(1),
                    c.label_adversary_weight, total, losses);
    }
  }
  if (c.pose_adversary) {
    const int64_t lead = c.adversary_frames - 1;
    const Tensor joined = torch::cat({past.slice(1, c.observed - lead), forecast}, 1);
    const Tensor views = adversary_views(joined, unseen(true_labels.slice(1, c.observed - lead)), b[kForecastStarts],
                                         c.adversary_frames);
    const auto run = b[kRun].item<int64_t>();
    const int64_t runs = std::min<int64_t>(kRuns, past.size(0)) / 2 * 2;
    const auto some = [&](const Tensor& all) { return all.slice(0, 0, runs); };
    const Tensor twice = past.slice(0, 0, runs / 2).repeat({2, 1, 1});
    Tensor labels = torch::zeros({runs, run + kRunFrames + c.gamma - 1, c.labels});
    {
      const torch::NoGradGuard no_gradients;
      if (c.intention)
        labels = model->intention->draw(model->intention->encode(twice),
                                        some(b[kGumbel]).slice(1, 0, run + kRunFrames + c.gamma - 1));
      state = model->pose->start(twice, some(b[kZ]));
      model->pose->roll(state, labels, run);
    }
    const Tensor later = labels.slice(1, run);
    const Tensor last = model->pose->roll(state, later, kRunFrames);
    const Tensor run_views = adversary_views(last, later, some(b[kRunStarts]), c.adversary_frames);
    const Tensor sameness = sameness_loss(last.slice(0, 0, runs / 2), last.slice(0, runs / 2), scale,
                                          kApart * pose_spread(b[kFrames].slice(0, 0, runs / 2), scale));
    total = total + c.diversity_weight * sameness;
    losses.emplace_back("sameness", sameness);
    add_adversary(model->pose_adversary, "pose",
                  adversary_views(b[kFrames], unseen(true_labels), b[kRealStarts], c.adversary_frames),
                  torch::cat({views, run_views}), c.adversary_weight, total, losses);
  }
  losses.insert(losses.begin(), {"total", total});
  return losses;
}

TrainTask intention_task(Networks& networks, const Data& data, const std::vector<Sequence>& validation) {
  const Config& c = networks.config;
  IntentionModel model(c);
  networks.intention = model->intention;
  networks.pose = model->pose;
  if (!c.intention) networks.intention = nullptr;
  TrainTask task;
  task.name = "intention";
  task.average = 0.995;  // adversaries make weights sway
  task.rate_factor = [](const std::string& name) { return name.find("adversary") != std::string::npos ? 2.0 : 1.0; };
  task.module = model.ptr();
  task.samples = data.size();
  task.prepare = [&](const std::vector<int64_t>& indices, uint64_t seed) {
    return intention_batch(data, c, indices, seed);
  };
  task.losses = [&, model](const Batch& b) { return intention_losses(model, b, c, networks.scale); };
  task.validate = [&] { return 1 - validation_ndms(networks, validation); };
  return task;
}

/// Past (B, t, F), future (B, T, F), 1 for frames that were recorded (B, T), and the seed of what the network drops
/// out.
Batch compared_batch(const Data& data, const Config& c, const std::vector<int64_t>& indices, uint64_t seed,
                     int64_t frames) {
  std::mt19937_64 random(seed);
  std::vector<Tensor> windows, known;
  for (const int64_t index : indices) {
    const auto window = data.sample(index, chance(random, 0.5));
    windows.push_back(window.frames);
    known.push_back((torch::arange(c.observed, c.observed + frames) < window.last).to(torch::kFloat32));
  }
  const Tensor all = torch::stack(windows);
  return {all.slice(1, 0, c.observed), all.slice(1, c.observed, c.observed + frames), torch::stack(known)};
}

/// Seq2Seq or LTD: joint error over the first second.
TrainTask compared_task(const std::string& name, Networks& networks, const Data& data,
                        const std::vector<Sequence>& validation) {
  const Config& c = networks.config;
  const int64_t frames =
      name == "trajectory" ? c.ltd_future : std::min<int64_t>(c.future, static_cast<int64_t>(c.rate));
  TrainTask task;
  task.name = name;
  if (name == "trajectory")
    task.module = (networks.trajectory = make_trajectory_network(c)).ptr();
  else
    task.module = (networks.seq2seq = Seq2SeqNetwork(c)).ptr();
  task.samples = data.size();
  task.prepare = [&, frames](const std::vector<int64_t>& indices, uint64_t seed) {
    return compared_batch(data, c, indices, seed, frames);
  };
  const bool trajectory = name == "trajectory";
  task.losses = [&, frames, trajectory](const Batch& b) {
    const Tensor forecast = trajectory ? networks.trajectory->forward(b[0].slice(1, c.observed - c.ltd_past))
                                       : networks.seq2seq->forward(b[0], frames);
    const Tensor rec = pose_reconstruction_loss(forecast, b[1], b[2], networks.scale),
                 root = root_reconstruction_loss(forecast, b[1], b[2]);
    return Losses{{"total", kPoseWeight * rec + kRootWeight * root}, {"rec", rec}, {"root", root}};
  };
  task.validate = [&, trajectory] { return validation_error(networks, trajectory, validation); };
  return task;
}

}  // namespace

bool train(const Training& options, Notes* notes) {
  const Config& config = options.config;
  validate(config, options.out);
  const std::vector<ActionMotion> motions = read_motion_set(options.data, config.rate, notes);

  using Choice = Training::Stage;
  std::vector<std::string> stages;
  if (options.stage == Choice::intention || options.stage == Choice::all) stages.push_back("intention");
  if (options.stage == Choice::seq2seq || options.stage == Choice::all) stages.push_back("seq2seq");
  if (options.stage == Choice::trajectory || options.stage == Choice::all) stages.push_back("trajectory");
  const size_t first = first_stage(options.out, stages, options.resume);

  Networks networks;
  networks.config = config;
  networks.skeleton = training_skeleton(motions, options.data);
  const auto train_sequences = sequences_of(motions, "train", networks.skeleton),
             validation = sequences_of(motions, "val", networks.skeleton);
  if (test_windows(validation, config, 1).empty())
    throw Error(options.data, "has no validation recording that is long enough");
  std::vector<Tensor> features;
  for (const Sequence& s : train_sequences)
    for (const Tensor& f : {s.features, mirrored_features(s.features)}) features.push_back(f);
  networks.scale = feature_scale(torch::cat(features));
  networks.clusters = cluster_recordings(train_sequences, config, options.seed);
  const Data data(train_sequences, networks);

  for (size_t s = first; s < stages.size(); ++s) {
    // The file holds the best of earlier stages and, each time this one validates better, its weights of that moment.
    Networks before;
    if (std::filesystem::exists(options.out) && (options.resume || s > 0 || options.stage != Choice::all))
      before = load_networks(options.out);
    const bool kept = (stages[s] != "intention" && !before.pose.is_empty()) ||
                      (stages[s] != "seq2seq" && !before.seq2seq.is_empty()) ||
                      (stages[s] != "trajectory" && !before.trajectory.is_empty());
    if (kept && !(before.config == config && before.scale.mean.allclose(networks.scale.mean, 1e-2, 1e-3)))
      throw Error(options.out, "holds other networks, trained with another configuration or on other data");
    torch::manual_seed(options.seed);
    TrainTask task = stages[s] == "intention" ? intention_task(networks, data, validation)
                                              : compared_task(stages[s], networks, data, validation);
    task.on_best = [&, name = stages[s]] {
      Networks best = networks;
      if (name != "intention") {
        best.intention = before.intention;
        best.pose = before.pose;
        if (!before.pose.is_empty()) best.clusters = before.clusters;  // that it was trained on
      }
      if (name != "seq2seq") best.seq2seq = before.seq2seq;
      if (name != "trajectory") best.trajectory = before.trajectory;
      save_networks(options.out, best);
    };
    TrainOptions loop = stage_options(options.out, s, first, options.resume);
    loop.steps = options.steps > 0 ? options.steps : stages[s] == "intention" ? 1600 : 2000;
    loop.batch = options.batch;
    loop.learning_rate = stages[s] == "intention" ? 5e-4 : 1e-3;
    loop.validate_every = std::max<int64_t>(1, loop.steps / 20);
    loop.seed = options.seed;
    if (train(task, loop).interrupted) return false;
  }
  return true;
}

}  // namespace inhabit::anticipate
