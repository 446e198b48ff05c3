#pragma once
#include "anticipate/people.h"
#include "inhabit/anticipate/model_file.h"

/// Sizes small enough to build and train in a test.
inline inhabit::Config small_anticipate_config() {
  inhabit::Config c;
  c.observed = 12;
  c.future = 16;
  c.label_frames = 19;
  c.gamma = 4;
  c.rec_frames = 6;
  c.labels = 3;
  c.clusters = 6;
  c.intention_hidden = 10;
  c.hidden = 14;
  c.noise = 5;
  c.intention_features = 4;
  c.adversary_hidden = 16;
  c.adversary_frames = 4;
  c.seq2seq_hidden = 12;
  c.ltd_past = 8;
  c.ltd_future = 6;
  c.ltd_hidden = 10;
  c.ltd_blocks = 1;
  return c;
}

/// All four networks, with weights of no training; scale and intention labels are those of people(60).
inline inhabit::Networks untrained(const inhabit::Config& config = small_anticipate_config()) {
  using namespace inhabit;
  Networks n;
  n.config = config;
  n.skeleton = builtin_body().skeleton;
  const auto recordings = people(60);
  std::vector<torch::Tensor> features;
  for (const Sequence& recording : recordings) features.push_back(recording.features);
  n.scale = feature_scale(torch::cat(features));
  n.clusters = cluster_recordings(recordings, config, 1);
  torch::manual_seed(6);
  if (config.intention) n.intention = IntentionNetwork(config);
  n.pose = PoseNetwork(config);
  n.seq2seq = Seq2SeqNetwork(config);
  n.trajectory = make_trajectory_network(config);
  if (config.intention) n.intention->eval();
  n.pose->eval();
  n.seq2seq->eval();
  n.trajectory->eval();
  return n;
}
