#include "inhabit/anticipate/config.h"

#include <algorithm>

#include "inhabit/error.h"
#include "inhabit/io/config_fields.h"

namespace inhabit::anticipate {
namespace {

constexpr auto fields = [](auto& c, const auto& visit) {
  visit("preset", c.preset);
  visit("rate", c.rate);
  visit("observed", c.observed);
  visit("future", c.future);
  visit("gamma", c.gamma);
  visit("kappa", c.kappa);
  visit("labels", c.labels);
  visit("clusters", c.clusters);
  visit("naive_clusters", c.naive_clusters);
  visit("released", c.released);
  visit("intention", c.intention);
  visit("memory", c.memory);
  visit("intention_hidden", c.intention_hidden);
  visit("hidden", c.hidden);
  visit("noise", c.noise);
  visit("intention_features", c.intention_features);
  visit("training.folds", c.training.folds);
  visit("training.fold", c.training.fold);
  visit("training.steps", c.training.steps);
  visit("training.batch", c.training.batch);
  visit("training.learning_rate", c.training.learning_rate);
  visit("training.average", c.training.average);
  visit("training.label_frames", c.training.label_frames);
  visit("training.rec_frames", c.training.rec_frames);
  visit("training.label_discriminator", c.training.label_discriminator);
  visit("training.pose_discriminator", c.training.pose_discriminator);
  visit("training.discriminator_hidden", c.training.discriminator_hidden);
  visit("training.discriminator_frames", c.training.discriminator_frames);
  visit("training.pose_discriminator_weight", c.training.pose_discriminator_weight);
  visit("training.label_discriminator_weight", c.training.label_discriminator_weight);
  visit("training.diversity_weight", c.training.diversity_weight);
  visit("training.plausibility_weight", c.training.plausibility_weight);
  visit("training.warmup", c.training.schedule.warmup);
  visit("training.rate_floor", c.training.schedule.floor);
  visit("inference.label_temperature", c.inference.label_temperature);
  visit("inference.memory_distance", c.inference.memory_distance);
  visit("inference.memory_typical", c.inference.memory_typical);
  visit("inference.memory_within", c.inference.memory_within);
  visit("inference.memory_stay", c.inference.memory_stay);
  visit("inference.memory_warp", c.inference.memory_warp);
  visit("inference.memory_label", c.inference.memory_label);
  visit("baselines.steps", c.baselines.steps);
  visit("baselines.learning_rate", c.baselines.learning_rate);
  visit("baselines.seq2seq_hidden", c.baselines.seq2seq_hidden);
  visit("baselines.ltd_past", c.baselines.ltd_past);
  visit("baselines.ltd_future", c.baselines.ltd_future);
  visit("baselines.ltd_hidden", c.baselines.ltd_hidden);
  visit("baselines.ltd_blocks", c.baselines.ltd_blocks);
  visit("baselines.hisrep_query", c.baselines.hisrep_query);
  visit("baselines.hisrep_future", c.baselines.hisrep_future);
  visit("baselines.hisrep_hidden", c.baselines.hisrep_hidden);
  visit("baselines.hisrep_blocks", c.baselines.hisrep_blocks);
  visit("baselines.vae_hidden", c.baselines.vae_hidden);
  visit("baselines.vae_latent", c.baselines.vae_latent);
  visit("baselines.dlow_samples", c.baselines.dlow_samples);
  visit("baselines.dlow_batch", c.baselines.dlow_batch);
  visit("baselines.mix_hidden", c.baselines.mix_hidden);
  visit("baselines.mix_latent", c.baselines.mix_latent);
  visit("baselines.grammar_hidden", c.baselines.grammar_hidden);
  visit("baselines.grammar_rules", c.baselines.grammar_rules);
  visit("baselines.grammar_rollouts", c.baselines.grammar_rollouts);
};

}  // namespace

std::string to_json(const Config& config) { return fields_to_json(config, fields).dump(); }

Config config_from_json(const std::string& text, const std::string& subject) {
  return inhabit::config_from_json<Config>(text, subject, fields);
}

Config preset(const std::string& name) {
  Config c;
  if (name == "paper") {
    c.preset = name;
    c.released = true;
    c.memory = false;
    c.hidden = 1024;
    c.noise = 32;
    c.intention_hidden = 12;
    c.intention_features = 32;
    c.future = 100;
    c.training.steps = 10000;
    c.training.batch = 64;
    c.training.learning_rate = 1e-4;
    c.training.average = 0;
    c.training.label_frames = 100;
    c.training.discriminator_hidden = 512;
  } else if (name != "compact") {
    throw Error("preset '" + name + "'", "unknown; there are compact and paper");
  }
  return c;
}

void set_fields(Config& c, const std::vector<std::string>& settings) { inhabit::set_fields(settings, fields, c); }

void validate(const Config& c, const std::string& subject) {
  const ConfigCheck check{subject};
  check.within("rate", c.rate, 1, 240);
  check.within("kappa", c.kappa, 2, 240);
  check.within("observed", c.observed, c.kappa, 2000);
  check.within("future", c.future, c.kappa, 2000);
  for (const auto& [name, steps] :
       {std::pair("training.steps", c.training.steps), {"baselines.steps", c.baselines.steps}})
    check.within(name, steps, 1, 1e8);
  check.within("training.folds", c.training.folds, 0, 1000);
  if (c.training.folds == 1) throw Error(subject, "training.folds is 0 or at least 2");
  check.within("training.fold", c.training.fold, 0, c.training.folds > 0 ? c.training.folds - 1 : 1000);
  check.within("training.batch", c.training.batch, 1, 100'000);
  check.within("training.learning_rate", c.training.learning_rate, 0, 100);
  check.within("baselines.learning_rate", c.baselines.learning_rate, 0, 100);
  check.within("baselines.dlow_samples", c.baselines.dlow_samples, 2, 1000);
  check.within("baselines.dlow_samples times baselines.vae_latent",
               static_cast<double>(c.baselines.dlow_samples) * c.baselines.vae_latent, 1, 1e6);
  check.within("baselines.dlow_batch", c.baselines.dlow_batch, 1, 100'000);
  check.within("baselines.grammar_rollouts", c.baselines.grammar_rollouts, 1, 1000);
  check.within("training.average", c.training.average, 0, 1 - 1e-9);
  check.within("training.label_frames", c.training.label_frames, 1, 2000);
  check.within("gamma", c.gamma, 1, 200);
  check.within("training.rec_frames", c.training.rec_frames, 0, 2000);
  check.within("labels", c.labels, 1, 256);
  check.within("clusters", c.clusters, 1, 1024);
  for (const auto& [name, width] : {std::pair("intention_hidden", c.intention_hidden),
                                    {"hidden", c.hidden},
                                    {"training.discriminator_hidden", c.training.discriminator_hidden},
                                    {"intention_features", c.intention_features},
                                    {"baselines.seq2seq_hidden", c.baselines.seq2seq_hidden},
                                    {"baselines.ltd_hidden", c.baselines.ltd_hidden},
                                    {"baselines.hisrep_hidden", c.baselines.hisrep_hidden},
                                    {"baselines.vae_hidden", c.baselines.vae_hidden},
                                    {"baselines.vae_latent", c.baselines.vae_latent},
                                    {"baselines.mix_hidden", c.baselines.mix_hidden},
                                    {"baselines.mix_latent", c.baselines.mix_latent},
                                    {"baselines.grammar_hidden", c.baselines.grammar_hidden},
                                    {"baselines.grammar_rules", c.baselines.grammar_rules}})
    check.within(name, width, 1, 4096);
  check.within("noise", c.noise, 0, c.hidden - 1);
  // Judged from the last observed frames on, and in stretches of 30 frames of longer runs.
  check.within("training.discriminator_frames", c.training.discriminator_frames, 2,
               std::min({c.future, c.observed, 30}));
  check.within("training.pose_discriminator_weight", c.training.pose_discriminator_weight, 0, 1000);
  check.within("inference.label_temperature", c.inference.label_temperature, 0, 10);
  check.within("inference.memory_distance", c.inference.memory_distance, 1e-6, 1e6);
  check.within("inference.memory_typical", c.inference.memory_typical, -1e6, 1e6);
  check.within("inference.memory_within", c.inference.memory_within, 0, 1e6);
  check.within("inference.memory_stay", c.inference.memory_stay, 0, 1e9);
  check.within("inference.memory_warp", c.inference.memory_warp, 0, 0.9);
  check.within("inference.memory_label", c.inference.memory_label, 0, 1e6);
  check.within("training.label_discriminator_weight", c.training.label_discriminator_weight, 0, 1000);
  check.within("training.diversity_weight", c.training.diversity_weight, 0, 1000);
  check.within("training.plausibility_weight", c.training.plausibility_weight, 0, 1000);
  if (c.released) {  // what its labels and poses need
    check.within("observed", c.observed, 50, 2000);
    check.within("future", c.future, 100, 2000);
    if (c.rate != 25) throw Error(subject, "the released networks know 25 frames a second");
  }
  check_schedule(check, c.training.schedule);
  check.within("baselines.ltd_past", c.baselines.ltd_past, 1, c.observed);
  check.within("baselines.ltd_future", c.baselines.ltd_future, 1, c.future);
  check.within("baselines.ltd_blocks", c.baselines.ltd_blocks, 1, 64);
  check.within("baselines.hisrep_query", c.baselines.hisrep_query, 2, 2000);
  check.within("baselines.hisrep_future", c.baselines.hisrep_future, 1, 2000);
  check.within("baselines.hisrep_blocks", c.baselines.hisrep_blocks, 1, 64);
}

}  // namespace inhabit::anticipate
