// Protects the networks: any horizon, gradients to every parameter, what Eq. 6 lets a pose depend on, and draws of
// labels that are one-hot with the gradient of the softmax.
#include "inhabit/anticipate/network.h"

#include <gtest/gtest.h>
#include <torch/csrc/autograd/autograd.h>

#include "anticipate/small_networks.h"
#include "gradients.h"
#include "inhabit/anticipate/losses.h"
#include "largest.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;
namespace F = torch::nn::functional;

Config without_memory() {
  Config c = small_anticipate_config();
  c.memory = false;
  return c;
}

/// Random labels, one-hot (B, T, C).
Tensor random_labels(int64_t batch, int64_t frames, const Config& c) {
  return F::one_hot(torch::randint(c.labels, {batch, frames}, torch::kInt64), c.labels).to(torch::kFloat32);
}

Tensor gumbel_noise(at::IntArrayRef shape) { return -(-torch::rand(shape).clamp(1e-6, 1 - 1e-6).log()).log(); }

TEST(AnticipationNetworks, ForecastAnyHorizon) {
  const torch::NoGradGuard no_gradients;
  const Config c = without_memory();
  torch::manual_seed(1);
  IntentionNetwork intention(c);
  PoseNetwork pose(c);
  Seq2SeqNetwork seq2seq(c);
  for (const int64_t frames : {1, 2, 16, 90}) {
    for (const int64_t observed : {2, 12, 30}) {
      const Tensor past = torch::randn({3, observed, kFeatureCount}), code = intention->encode(past);
      EXPECT_EQ(code.sizes(), (torch::IntArrayRef{3, c.intention_hidden}));
      const int64_t ahead = frames + c.gamma - 1;
      const Tensor drawn = intention->draw(code, gumbel_noise({3, ahead, c.labels}));
      EXPECT_EQ(drawn.sizes(), (torch::IntArrayRef{3, ahead, c.labels}));
      EXPECT_EQ(intention->teacher_logits(code, drawn).sizes(), drawn.sizes());
      PoseNetworkImpl::State state = pose->start(past, torch::randn({3, c.noise}));
      const Tensor future = pose->roll(state, drawn, frames);
      EXPECT_EQ(future.sizes(), (torch::IntArrayRef{3, frames, kFeatureCount}));
      EXPECT_TRUE(torch::equal(state.pose, future.select(1, frames - 1)));
      EXPECT_EQ(seq2seq->forward(past, frames).sizes(), future.sizes());
    }
  }
}

TEST(AnticipationNetworks, GradientsReachEveryParameter) {
  const Config c = without_memory();
  torch::manual_seed(2);
  const Tensor past = torch::randn({4, 12, kFeatureCount}), mix = torch::randn({4, 9, kFeatureCount});
  PoseNetwork pose(c);
  PoseNetworkImpl::State state = pose->start(past, torch::randn({4, c.noise}));
  (pose->roll(state, random_labels(4, 9 + c.gamma - 1, c), 9) * mix).sum().backward();
  expect_gradients_everywhere(*pose);

  const Tensor labels = random_labels(4, 6, c);
  IntentionNetwork intention(c);
  intention_loss(intention->teacher_logits(intention->encode(past), labels), labels.argmax(2), torch::ones({4, 6}))
      .backward();
  expect_gradients_everywhere(*intention);
  intention->zero_grad();  // through the drawn labels, as the discriminator's gradient comes
  (intention->draw(intention->encode(past), gumbel_noise({4, 6, c.labels})) * torch::randn({4, 6, c.labels}))
      .sum()
      .backward();
  expect_gradients_everywhere(*intention);

  Discriminator discriminator(30, c.training.discriminator_hidden, 2);
  discriminator_loss(discriminator->forward(torch::randn({8, 30})), discriminator->forward(torch::randn({8, 30})))
      .backward();
  expect_gradients_everywhere(*discriminator);

  Seq2SeqNetwork seq2seq(c);
  (seq2seq->forward(past, 9) * mix).sum().backward();
  expect_gradients_everywhere(*seq2seq);
}

TEST(PoseNetwork, ReadsTheIntentionExactlyGammaFramesAhead) {
  const torch::NoGradGuard no_gradients;
  for (const int gamma : {1, 4}) {
    Config c = without_memory();
    c.gamma = gamma;
    torch::manual_seed(3);
    PoseNetwork pose(c);
    const int64_t frames = 10;
    const Tensor past = torch::randn({1, 12, kFeatureCount}), z = torch::randn({1, c.noise}),
                 labels = random_labels(1, frames + gamma - 1, c);
    const auto future = [&](const Tensor& intention) {
      PoseNetworkImpl::State state = pose->start(past, z);
      return pose->roll(state, intention, frames)[0];
    };
    const Tensor before = future(labels);
    for (int64_t at = 0; at < frames + gamma - 1; ++at) {
      Tensor other = labels.clone();
      other[0][at] = labels[0][at].roll({1}, {0});
      const Tensor change = std::get<0>((future(other) - before).abs().max(1));
      // Pose i reads labels i to i + gamma - 1.
      const int64_t first = std::max<int64_t>(0, at - gamma + 1);
      if (first > 0) {
        EXPECT_LT(largest(change.slice(0, 0, first)), 1e-7) << "gamma " << gamma << ", label " << at;
      }
      EXPECT_GT(change[first].item<double>(), 1e-5) << "gamma " << gamma << ", label " << at;
    }
  }
}

TEST(PoseNetwork, NoiseChangesTheFutureFromItsFirstFrameOn) {
  const torch::NoGradGuard no_gradients;
  const Config c = without_memory();
  torch::manual_seed(4);
  PoseNetwork pose(c);
  const Tensor past = torch::randn({1, 12, kFeatureCount}).expand({2, -1, -1}),
               labels = random_labels(1, 8 + c.gamma - 1, c).expand({2, -1, -1});
  Tensor z = torch::randn({2, c.noise});
  PoseNetworkImpl::State state = pose->start(past, z);
  const Tensor parted = pose->roll(state, labels, 8);
  EXPECT_GT((parted[0] - parted[1]).abs().amax(1).min().item<double>(), 1e-5);
  state = pose->start(past, z.slice(0, 0, 1).expand({2, -1}));
  const Tensor alike = pose->roll(state, labels, 8);
  EXPECT_LT(largest(alike[0] - alike[1]), 1e-7) << "the noise alone parts them";
}

TEST(PoseNetwork, GoesOnWhereItStopped) {
  const torch::NoGradGuard no_gradients;
  const Config c = without_memory();
  torch::manual_seed(5);
  PoseNetwork pose(c);
  const Tensor past = torch::randn({2, 12, kFeatureCount}), z = torch::randn({2, c.noise}),
               labels = random_labels(2, 20 + c.gamma - 1, c);
  PoseNetworkImpl::State state = pose->start(past, z);
  const Tensor whole = pose->roll(state, labels, 20);
  state = pose->start(past, z);
  const Tensor head = pose->roll(state, labels, 13), tail = pose->roll(state, labels.slice(1, 13), 7);
  EXPECT_LT(largest(torch::cat({head, tail}, 1) - whole), 1e-5);
}

TEST(ResidualNetworks, HoldTheLastPoseWhereNothingIsAdded) {
  const torch::NoGradGuard no_gradients;
  const Config c = without_memory();
  torch::manual_seed(6);
  PoseNetwork pose(c);
  Seq2SeqNetwork seq2seq(c);
  for (const torch::nn::Linear& out : {pose->out, seq2seq->out}) {
    out->weight.zero_();
    out->bias.zero_();
  }
  pose->pull.fill_(-100);
  const Tensor past = torch::randn({2, 12, kFeatureCount}), held = past.slice(1, 11).expand({-1, 5, -1});
  PoseNetworkImpl::State state = pose->start(past, torch::randn({2, c.noise}));
  EXPECT_TRUE(torch::equal(pose->roll(state, random_labels(2, 5 + c.gamma - 1, c), 5), held));
  EXPECT_TRUE(torch::equal(seq2seq->forward(past, 5), held));
}

TEST(PoseNetwork, IsDrawnTowardsThePoseThatItsStateNamesByTheLearnedWeight) {
  const torch::NoGradGuard no_gradients;
  const Config c = without_memory();
  torch::manual_seed(11);
  PoseNetwork pose(c);
  const Tensor change = torch::randn({kFeatureCount}), named = torch::randn({kFeatureCount});
  pose->out->weight.zero_();
  pose->out->bias.copy_(torch::cat({change, named}));
  pose->pull.copy_(torch::randn({kFeatureCount}));
  const Tensor past = torch::randn({1, 12, kFeatureCount}), last = past[0][11], weight = pose->pull.sigmoid();
  PoseNetworkImpl::State state = pose->start(past, torch::randn({1, c.noise}));
  const Tensor future = pose->roll(state, random_labels(1, 2 + c.gamma - 1, c), 2)[0];
  const Tensor first = last + change + weight * (named - last);
  EXPECT_LT(largest(future[0] - first), 1e-5);
  EXPECT_LT(largest(future[1] - (first + change + weight * (named - first))), 1e-5);
}

/// Something to follow, standardised.
Followed anything_to_follow(int64_t batch, int64_t frames) {
  return {torch::randn({batch, frames, kFeatureCount}), torch::randn({batch, frames, kFeatureCount}), {}};
}

TEST(PoseNetwork, BeginsByFollowingWhatItIsGiven) {
  const torch::NoGradGuard no_gradients;
  const Config c = small_anticipate_config();
  torch::manual_seed(12);
  PoseNetwork pose(c);
  pose->out->weight.zero_();
  pose->pull.copy_(torch::randn({kFeatureCount}));
  const Followed followed = anything_to_follow(1, 3);
  const Tensor past = torch::randn({1, 12, kFeatureCount}), weight = pose->pull.sigmoid();
  PoseNetworkImpl::State state = pose->start(past, torch::randn({1, c.noise}));
  const Tensor labels = random_labels(1, 3 + c.gamma - 1, c), future = pose->roll(state, labels, 3, followed)[0];
  Tensor expected = past[0][11];
  for (int64_t t = 0; t < 3; ++t) {
    expected = expected + followed.changes[0][t] + weight * (followed.features[0][t] - expected);
    EXPECT_LT(largest(future[t] - expected), 1e-5) << t;
  }
}

TEST(PoseNetwork, LearnsFromWhatItFollows) {
  const Config c = small_anticipate_config();
  torch::manual_seed(13);
  PoseNetwork pose(c);
  const Tensor past = torch::randn({4, 12, kFeatureCount}), mix = torch::randn({4, 9, kFeatureCount});
  const Followed followed = anything_to_follow(4, 9);
  PoseNetworkImpl::State state = pose->start(past, torch::randn({4, c.noise}));
  const Tensor labels = random_labels(4, 9 + c.gamma - 1, c);
  (pose->roll(state, labels, 9, followed) * mix).sum().backward();
  expect_gradients_everywhere(*pose);
  const torch::NoGradGuard no_gradients;
  state = pose->start(past, torch::zeros({4, c.noise}));
  const Tensor whole = pose->roll(state, labels, 9, followed);
  state = pose->start(past, torch::zeros({4, c.noise}));
  const Tensor head = pose->roll(state, labels, 5, followed),
               tail = pose->roll(state, labels.slice(1, 5), 4,
                                 {followed.features.slice(1, 5), followed.changes.slice(1, 5), {}});
  EXPECT_LT(largest(torch::cat({head, tail}, 1) - whole), 1e-5) << "goes on where it stopped";
}

TEST(IntentionNetwork, DrawsAreOneHotAndSpreadAsTheNoiseHasIt) {
  const torch::NoGradGuard no_gradients;
  const Config c = without_memory();
  torch::manual_seed(7);
  IntentionNetwork intention(c);
  const Tensor state = intention->encode(torch::randn({1, 12, kFeatureCount})).expand({4000, -1});
  const Tensor drawn = intention->draw(state, gumbel_noise({4000, 2, c.labels}));
  EXPECT_LT(largest(drawn.sum(2) - 1), 1e-6);
  EXPECT_LT(largest(drawn.amax(2) - 1), 1e-6);
  // Gumbel noise draws each label as often as the softmax has it: 4000 draws are within 4 deviations, 0.032.
  const Tensor expected = intention->out->forward(state.slice(0, 0, 1)).softmax(1)[0];
  EXPECT_LT(largest(drawn.select(1, 0).mean(0) - expected), 0.032);
}

TEST(IntentionNetwork, DrawsHaveTheGradientOfTheSoftmax) {
  const Config c = without_memory();
  torch::manual_seed(8);
  IntentionNetwork intention(c);
  const Tensor state = torch::randn({5, c.intention_hidden}), mix = torch::randn({5, c.labels});
  Tensor gumbel = gumbel_noise({5, 1, c.labels}).requires_grad_(true);
  const Tensor got = torch::autograd::grad({(intention->draw(state, gumbel).select(1, 0) * mix).sum()}, {gumbel})[0];
  const Tensor soft = (intention->out->forward(state) + gumbel.select(1, 0)).softmax(1);
  const Tensor expected = torch::autograd::grad({(soft * mix).sum()}, {gumbel})[0];
  EXPECT_GT(largest(expected), 1e-3);
  EXPECT_LT(largest(got - expected), 1e-6);
}

TEST(IntentionNetwork, ALabelChangesThoseAfterItAlone) {
  const torch::NoGradGuard no_gradients;
  const Config c = without_memory();
  torch::manual_seed(9);
  IntentionNetwork intention(c);
  const Tensor code = intention->encode(torch::randn({1, 12, kFeatureCount})), labels = random_labels(1, 8, c);
  Tensor other = labels.clone();
  other[0][3] = labels[0][3].roll({1}, {0});
  const Tensor change = (intention->teacher_logits(code, other) - intention->teacher_logits(code, labels))[0].abs();
  EXPECT_LT(largest(change.slice(0, 0, 4)), 1e-7) << "a label is not told to its own forecast";
  EXPECT_GT(change[4].max().item<double>(), 1e-4);
}

}  // namespace
}  // namespace inhabit::anticipate
