#include "inhabit/anticipate/train_baselines.h"

#include <algorithm>
#include <filesystem>

#include "inhabit/anticipate/evaluate.h"
#include "inhabit/anticipate/futures.h"
#include "inhabit/anticipate/losses.h"
#include "inhabit/anticipate/on_cpu.h"
#include "inhabit/anticipate/variational_futures.h"
#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/nn/random_tensor.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

// Of the deterministic ones, as of ours (train.cpp).
constexpr double kJointWeight = 40, kRootMotionWeight = 1;
// Of the stochastic ones, as in DLow's released configuration; a standardised step of the root counts as 0.1 m.
constexpr double kFirstStep = 1000, kDivergence = 0.1;
constexpr double kDiversity = 25, kNearest = 2;
constexpr double kApartInAFrame = 1;  // square metres
constexpr double kRootUnit = 0.1;
constexpr double kGrammarGenerator = 1;

/// Windows as these networks are trained on them.
struct BaselineBatch {
  Tensor past;         // (B, t, F)
  Tensor future;       // (B, T, F)
  Tensor known;        // (B, T) 1 for frames that were recorded
  Tensor noise = {};   // (B, Z) normal; of the stochastic ones
  Tensor taken = {};   // (H) places of Mix-and-Match
  Tensor gumbel = {};  // (B K, T, R) of the grammar's rollouts

  BaselineBatch on(torch::Device d) const {
    const auto moved = [&](const Tensor& x) { return x.defined() ? x.to(d) : x; };
    return {past.to(d), future.to(d), known.to(d), moved(noise), moved(taken), moved(gumbel)};
  }
};

/// What a batch holds beside its windows.
struct BaselineDraws {
  int64_t frames = 0;    // of future
  int64_t latent = 0;    // Z
  int64_t places = 0;    // H
  int64_t rollouts = 0;  // K
  int64_t rules = 0;     // R
};

BaselineBatch baseline_batch(const Data& data, const Config& c, const TrainStep& step, const BaselineDraws& draws) {
  std::mt19937_64 random(step.seed);
  std::vector<Tensor> windows, known;
  for (const int64_t index : step.indices) {
    const auto window = data.sample(index, chance(random, 0.5));
    windows.push_back(window.frames);
    known.push_back((torch::arange(c.observed, c.observed + draws.frames) < window.last).to(torch::kFloat32));
  }
  const Tensor all = torch::stack(windows);
  BaselineBatch out{all.slice(1, 0, c.observed), all.slice(1, c.observed, c.observed + draws.frames),
                    torch::stack(known)};
  if (draws.latent > 0) out.noise = nn::normal_tensor(random, {all.size(0), draws.latent});
  if (draws.places > 0) out.taken = half_of_places(draws.places, random);
  if (draws.rules > 0)
    out.gumbel = nn::gumbel_tensor(random, {all.size(0) * draws.rollouts, draws.frames, draws.rules});
  return out;
}

/// How a network is trained.
struct Baseline {
  BaselineDraws draws;
  std::shared_ptr<torch::nn::Module> network;
  std::function<Losses(const BaselineBatch& batch)> losses;
  std::function<double()> validate;
  std::vector<std::shared_ptr<torch::nn::Module>> used = {};   ///< others that the losses and validate() look at
  std::shared_ptr<torch::nn::Module> with_discriminator = {};  ///< the network beside what is trained with it
};

/// One that forecasts one future. @param forecast (B, observed, F) -> (B, frames, F), standardised
template <class Forecast>
Baseline deterministic(int64_t frames, std::shared_ptr<torch::nn::Module> network, const FeatureScale& scale,
                       Forecast forecast, std::function<double()> validate) {
  return {{frames},
          std::move(network),
          [scale, forecast](const BaselineBatch& b) mutable {
            const Tensor future = forecast(b.past);
            const Tensor rec = pose_reconstruction_loss(future, b.future, b.known, scale),
                         root = root_reconstruction_loss(future, b.future, b.known);
            return Losses{{"total", kJointWeight * rec + kRootMotionWeight * root}, {"rec", rec}, {"root", root}};
          },
          std::move(validate)};
}

/// What a standardised feature counts for in metres: (F).
Tensor feature_metres(const FeatureScale& scale) {
  Tensor out = scale.deviation.clone();
  out.slice(0, kPoseFeatures).fill_(kRootUnit);
  return out;
}

/// Sum over frames and features of squared errors, m^2, (B): of known frames.
Tensor squared_error(const Tensor& future, const Tensor& truth, const Tensor& known, const Tensor& metres) {
  return (((future - truth) * metres).square().sum(2) * known).sum(1);
}

/// Reconstruction, step into the first frame, and divergence from N(0, 1).
Losses variational_losses(const Tensor& future, const BaselineBatch& b, const nn::LatentDistribution& z,
                          const Tensor& metres) {
  const Tensor rec = squared_error(future, b.future, b.known, metres).mean();
  const Tensor last = b.past.select(1, b.past.size(1) - 1);
  const Tensor step = ((future.select(1, 0) - last) * metres).square().sum(1).mean();
  const Tensor divergence = z.summed_divergence();
  return {{"total", rec + kFirstStep * step + kDivergence * divergence},
          {"rec", rec},
          {"step", step},
          {"divergence", divergence}};
}

Baseline vae_baseline(Networks& networks, const FeatureScale& scale, std::function<double()> validate) {
  const Config& c = networks.config;
  networks.vae = MotionVae(c);
  return {{c.future, c.baselines.vae_latent},
          networks.vae.ptr(),
          [vae = networks.vae, metres = feature_metres(scale)](const BaselineBatch& b) mutable {
            const Tensor code = vae->encode(b.past);
            const nn::LatentDistribution z = vae->posterior(code, b.future);
            const Tensor future =
                vae->decode(code, z.sample(b.noise), b.past.select(1, b.past.size(1) - 1), b.future.size(1));
            return variational_losses(future, b, z, metres);
          },
          std::move(validate)};
}

Baseline mix_match_baseline(Networks& networks, const FeatureScale& scale, std::function<double()> validate) {
  const Config& c = networks.config;
  networks.mix_match = MixMatchNetwork(c);
  return {{c.future, c.baselines.mix_latent, c.baselines.mix_hidden},
          networks.mix_match.ptr(),
          [network = networks.mix_match, metres = feature_metres(scale)](const BaselineBatch& b) mutable {
            const Tensor code = network->encode(b.past);
            const nn::LatentDistribution z = network->posterior(code, b.future, b.taken);
            const Tensor future = network->decode(code, z.sample(b.noise), b.taken,
                                                  b.past.select(1, b.past.size(1) - 1), b.future.size(1));
            return variational_losses(future, b, z, metres);
          },
          std::move(validate)};
}

/// The sampler of a VAE that stays as it is.
Baseline dlow_baseline(Networks& networks, const FeatureScale& scale, const TrainRun& run,
                       std::function<double()> validate) {
  const Config& c = networks.config;
  if (std::filesystem::exists(run.out)) networks.vae = load_networks(run.out).vae;
  if (networks.vae.is_empty()) throw Error(run.out, "holds no VAE, whose futures dlow diversifies: train vae first");
  networks.vae->to(run.device);
  for (Tensor& p : networks.vae->parameters()) p.set_requires_grad(false);
  networks.dlow = LatentSampler(c);
  return {
      {c.future, c.baselines.vae_latent},
      networks.dlow.ptr(),
      [sampler = networks.dlow, vae = networks.vae, metres = feature_metres(scale)](const BaselineBatch& b) mutable {
        const int64_t samples = sampler->samples, frames = b.future.size(1);
        const auto [factor, shift] = sampler->forward(b.past);  // (B, K, Z)
        const Tensor z = (factor * b.noise.unsqueeze(1) + shift).flatten(0, 1);
        const auto of_each = [&](const Tensor& x) { return x.repeat_interleave(samples, 0); };
        const Tensor futures =
            vae->decode(of_each(vae->encode(b.past)), z, of_each(b.past.select(1, b.past.size(1) - 1)), frames);
        const Tensor nearest =
            std::get<0>(squared_error(futures, of_each(b.future), of_each(b.known), metres).view({-1, samples}).min(1));
        const Tensor same = sameness_of_pairs((futures * metres).view({-1, samples, frames * kFeatureCount}),
                                              kApartInAFrame * static_cast<double>(frames));
        const Tensor divergence =
            nn::LatentDistribution{shift.flatten(0, 1), factor.flatten(0, 1).square().clamp_min(1e-8).log()}
                .summed_divergence();
        const Tensor rec = nearest.mean();
        return Losses{{"total", divergence + kDiversity * same + kNearest * rec},
                      {"rec", rec},
                      {"sameness", same},
                      {"divergence", divergence}};
      },
      std::move(validate),
      {networks.vae.ptr()}};
}

/// The grammar beside its discriminator of a whole forecast, which lives only while it is trained.
struct AdversarialGrammarImpl : torch::nn::Module {
  explicit AdversarialGrammarImpl(const Config& c) {
    grammar = register_module("grammar", GrammarNetwork(c));
    discriminator = register_module(
        "discriminator", Discriminator((2 * c.future + 1) * kFeatureCount, c.training.discriminator_hidden, 2));
  }
  GrammarNetwork grammar{nullptr};
  Discriminator discriminator{nullptr};
};
TORCH_MODULE(AdversarialGrammar);

/// What the grammar's discriminator sees: the last observed pose (B, F), the poses of the forecast (B, T, F) and their
/// changes: (B, D). Beyond the end of the recording (known (B, T)) all are zero.
Tensor grammar_view(const Tensor& last, const Tensor& future, const Tensor& known) {
  const Tensor before = torch::cat({last.unsqueeze(1), future.slice(1, 0, -1)}, 1);
  const auto seen = [&](const Tensor& x) { return (x * known.unsqueeze(2)).flatten(1); };
  return torch::cat({last, seen(future), seen((future - before) * kVelocityScale)}, 1);
}

/// Of each observation's rollouts the one that is nearest to the truth is drawn to it, and all must look real.
Baseline grammar_baseline(Networks& networks, const FeatureScale& scale, std::function<double()> validate) {
  const Config& c = networks.config;
  AdversarialGrammar model(c);
  networks.grammar = model->grammar;
  const int64_t rollouts = c.baselines.grammar_rollouts;
  return {
      {.frames = c.future, .rollouts = rollouts, .rules = c.baselines.grammar_rules},
      networks.grammar.ptr(),
      [model, rollouts, metres = feature_metres(scale)](const BaselineBatch& b) mutable {
        const auto of_each = [&](const Tensor& x) { return x.repeat_interleave(rollouts, 0); };
        const Tensor last = b.past.select(1, b.past.size(1) - 1);
        const Tensor futures = model->grammar->produce(of_each(model->grammar->start(b.past)), b.gumbel, of_each(last));
        const Tensor rec =
            std::get<0>(squared_error(futures, of_each(b.future), of_each(b.known), metres).view({-1, rollouts}).min(1))
                .mean();
        Losses losses{{"rec", rec}};
        Tensor total = rec;
        add_discriminator(model->discriminator, "pose", grammar_view(last, b.future, b.known),
                          grammar_view(of_each(last), futures, of_each(b.known)), kGrammarGenerator, total, losses);
        losses.insert(losses.begin(), {"total", total});
        return losses;
      },
      std::move(validate),
      {},
      model.ptr()};
}

/// Of the name of its stage.
Baseline make_baseline(const std::string& name, Networks& networks, const std::vector<Sequence>& validation,
                       const TrainRun& run) {
  const Config& c = networks.config;
  const FeatureScale scale = networks.scale.to(run.device);
  const auto by_error = [&](BaselineFuture future) {
    return [&networks, &validation, future] { return validation_error(networks, future, validation); };
  };
  const auto by_nearest = [&](StochasticFutures method, int64_t futures) {
    return [&networks, &validation, method, futures] {
      return nearest_validation_error(networks, method, futures, validation);
    };
  };
  constexpr int64_t kDrawn = 10;
  if (name == "vae") return vae_baseline(networks, scale, by_nearest(vae_futures, kDrawn));
  if (name == "dlow")  // its futures are no draws that are alike
    return dlow_baseline(networks, scale, run, by_nearest(dlow_futures, c.baselines.dlow_samples));
  if (name == "mix_match") return mix_match_baseline(networks, scale, by_nearest(mix_match_futures, kDrawn));
  if (name == "grammar") return grammar_baseline(networks, scale, by_nearest(grammar_futures, kDrawn));
  if (name == "ltd") {
    networks.ltd = make_ltd(c);
    return deterministic(
        c.baselines.ltd_future, networks.ltd.ptr(), scale,
        [network = networks.ltd, from = c.observed - c.baselines.ltd_past](const Tensor& past) mutable {
          return network->forward(past.slice(1, from));
        },
        by_error(ltd_future));
  }
  if (name == "hisrep") {
    networks.hisrep = make_hisrep(c);
    return deterministic(
        c.baselines.hisrep_future, networks.hisrep.ptr(), scale,
        [network = networks.hisrep](const Tensor& past) mutable { return network->forward(past); },
        by_error(hisrep_future));
  }
  networks.seq2seq = Seq2SeqNetwork(c);
  const int64_t second = std::min<int64_t>(c.future, static_cast<int64_t>(c.rate));
  return deterministic(
      second, networks.seq2seq.ptr(), scale,
      [network = networks.seq2seq, second](const Tensor& past) mutable { return network->forward(past, second); },
      by_error(seq2seq_future));
}

}  // namespace

TrainTask baseline_task(const std::string& name, Networks& networks, const Data& data,
                        const std::vector<Sequence>& validation, const TrainRun& run) {
  const Config& c = networks.config;
  const Baseline baseline = make_baseline(name, networks, validation, run);
  TrainTask task;
  task.module = baseline.with_discriminator ? baseline.with_discriminator : baseline.network;
  task.rate_factor = faster_discriminators;
  task.networks = {{name + "_net.", baseline.network}};
  if (name == "vae") task.outdated = {"dlow_net."};
  task.samples = data.size();
  task.prepare =
      batches([&, draws = baseline.draws](const TrainStep& step) { return baseline_batch(data, c, step, draws); },
              [device = run.device, losses = baseline.losses](const BaselineBatch& b, const TrainStep&) {
                return losses(b.on(device));
              });
  task.validate = [baseline, device = run.device] {
    std::vector<std::shared_ptr<torch::nn::Module>> modules = baseline.used;
    modules.push_back(baseline.network);
    const OnCpu moved(device, modules);
    return baseline.validate();
  };
  return task;
}

}  // namespace inhabit::anticipate
