#pragma once
#include "anticipate/people.h"
#include "inhabit/anticipate/model_file.h"

/// Sizes small enough to build and train in a test.
inline inhabit::anticipate::Config small_anticipate_config() {
  inhabit::anticipate::Config c;
  c.observed = 12;
  c.future = 16;
  c.training.label_frames = 19;
  c.gamma = 4;
  c.training.rec_frames = 6;
  c.labels = 3;
  c.clusters = 6;
  c.intention_hidden = 10;
  c.hidden = 14;
  c.noise = 5;
  c.intention_features = 4;
  c.training.discriminator_hidden = 16;
  c.training.discriminator_frames = 4;
  c.baselines.seq2seq_hidden = 12;
  c.baselines.ltd_past = 8;
  c.baselines.ltd_future = 6;
  c.baselines.ltd_hidden = 10;
  c.baselines.ltd_blocks = 1;
  c.baselines.hisrep_query = 4;
  c.baselines.hisrep_future = 5;
  c.baselines.hisrep_hidden = 10;
  c.baselines.hisrep_blocks = 1;
  c.baselines.vae_hidden = 10;
  c.baselines.vae_latent = 6;
  c.baselines.dlow_samples = 4;
  c.baselines.dlow_batch = 3;
  c.baselines.mix_hidden = 12;
  c.baselines.mix_latent = 5;
  c.baselines.grammar_hidden = 9;
  c.baselines.grammar_rules = 7;
  c.baselines.grammar_rollouts = 3;
  return c;
}

/// All networks, with weights of no training; scale, intention labels and memory are those of people(60).
inline inhabit::anticipate::Networks untrained(const inhabit::anticipate::Config& config = small_anticipate_config()) {
  using namespace inhabit;
  using namespace inhabit::anticipate;
  Networks n;
  n.config = config;
  n.skeleton = builtin_body().skeleton;
  const auto recordings = people(60);
  std::vector<torch::Tensor> features;
  for (const Sequence& recording : recordings) features.push_back(recording.features);
  n.scale = feature_scale(torch::cat(features));
  n.clusters = cluster_recordings(recordings, config, 1);
  if (config.memory) n.memory = make_memory(remembered_motion(recordings, config.kappa), n.clusters, config, "people");
  torch::manual_seed(6);
  if (config.intention) n.intention = IntentionNetwork(config);
  n.pose = PoseNetwork(config);
  n.seq2seq = Seq2SeqNetwork(config);
  n.ltd = make_ltd(config);
  n.hisrep = make_hisrep(config);
  n.vae = MotionVae(config);
  n.dlow = LatentSampler(config);
  n.mix_match = MixMatchNetwork(config);
  n.grammar = GrammarNetwork(config);
  if (config.intention) n.intention->eval();
  n.pose->eval();
  n.seq2seq->eval();
  n.ltd->eval();
  n.hisrep->eval();
  return n;
}
