// Protects the evaluation: a planted network that goes on as the recordings do has NDMS 1 and no error, the last pose
// held has the closed forms, and the tables have every row, with nothing where the recordings end.
#include "inhabit/anticipate/evaluate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "anticipate/small_networks.h"
#include "inhabit/anticipate/simple_futures.h"
#include "inhabit/anticipate/variational_futures.h"
#include "inhabit/anticipate/window_scores.h"
#include "inhabit/metrics/score_motions.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

const Scores* row_of(const Table& table, const std::string& action, const std::string& method) {
  for (const auto& entry : table.actions)
    for (const Scores& row : entry.rows)
      if (entry.name == action && row.method == method) return &row;
  return nullptr;
}

Table evaluate_one(const Networks& networks, const std::vector<Sequence>& test, const Evaluation& options,
                   const std::vector<Sequence>& training = {}) {
  return evaluate({Fold{networks, test, training}}, options);
}

/// Every joint but the hips goes straight on at its own 1 to 2 cm a frame; the root goes 5 cm a frame ahead.
struct Straight {
  Tensor change = torch::zeros({kFeatureCount});
  double mean_speed = 0;  // metres a frame, over 21 joints

  Straight() {
    for (int64_t j = 2; j < 21; ++j) {
      change[3 * j + j % 3] = 0.01 + 0.0005 * static_cast<double>(j);
      mean_speed += (0.01 + 0.0005 * static_cast<double>(j)) / 21;
    }
  }
  Sequence recording(const std::string& name, const std::string& action, int64_t frames) const {
    Tensor first = person("wave", 2).joints.slice(0, 0, 1);
    Tensor features = joint_features(first) + torch::arange(frames).unsqueeze(1) * change;
    features.select(1, 64).fill_(0.05);
    return {name, action, features.contiguous()};
  }
  /// Networks whose pose decoder adds `change` every frame.
  Networks planted() const {
    const torch::NoGradGuard no_gradients;
    Config c = small_anticipate_config();
    c.memory = false;
    Networks n = untrained(c);
    n.seq2seq = nullptr;
    n.ltd = nullptr;
    n.hisrep = nullptr;
    n.vae = nullptr;
    n.dlow = nullptr;
    n.mix_match = nullptr;
    n.grammar = nullptr;
    n.pose->out->weight.zero_();
    n.pose->out->bias.zero_();
    n.pose->out->bias.slice(0, 0, kFeatureCount).copy_(change / n.scale.deviation);
    n.pose->pull.fill_(-100);
    return n;
  }
};

TEST(EvaluateAnticipate, GoingOnAsRecordedIsPerfectAndHoldingStillIsTheClosedForm) {
  const Straight straight;
  const Table table = evaluate_one(straight.planted(), {straight.recording("a", "drift", 250)}, {3, 2, 10, 1});
  EXPECT_EQ(table.horizons, (std::vector<double>{0.4, 0.8, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2, 3.6, 4.0, 10.0}));
  EXPECT_EQ(table.samples, 3);
  ASSERT_EQ(table.actions.size(), 2U) << "the action and the mean";
  EXPECT_EQ(table.actions[0].windows, 2);
  EXPECT_EQ(table.actions[0].words, 2 * (250 - 8 + 1)) << "and the mirror image's";
  const Scores *ours = row_of(table, "drift", "ours"), *held = row_of(table, "drift", "last pose held");
  ASSERT_TRUE(ours != nullptr && held != nullptr);
  for (size_t i = 0; i < 10; ++i) {
    const double frames = 25 * table.horizons[i];
    // Hips stand still in both: no magnitude, as Eq. 12 has it; 10 of 12 joints move.
    EXPECT_NEAR(ours->ndms[i], 10.0 / 12, 2e-3) << i;
    EXPECT_GE(ours->coded[i], ours->ndms[i] - 1e-9) << i;
    EXPECT_NEAR(ours->error[i], 0, 0.5) << i;
    EXPECT_NEAR(ours->best_error[i], 0, 0.5) << i;
    EXPECT_NEAR(ours->root_error[i], 0, 0.5) << i;
    EXPECT_NEAR(ours->apd[i], 0, 1e-4) << i;
    EXPECT_NEAR(held->error[i], 1000 * frames * straight.mean_speed, 0.5) << i;
    EXPECT_NEAR(held->root_error[i], 1000 * frames * 0.05, 0.5) << i;
    EXPECT_EQ(held->apd[i], 0) << i;
    // Words of the first 0.4 s (10 frames) hold 6, 5, ... 0 observed steps of 7; steps on the spot score nothing.
    EXPECT_NEAR(held->ndms[i], (i == 0 ? 21.0 / 70 : 0) * 10 / 12, 2e-3) << i;
  }
  EXPECT_NEAR(ours->npss, 0, 1e-3);
  EXPECT_NEAR(ours->speed_ratio, 1, 1e-2);
  EXPECT_GT(held->npss, ours->npss);
  EXPECT_NEAR(ours->seam, 1000 * straight.mean_speed * 21 / 22, 0.05) << "the step of a person who goes on";
  EXPECT_EQ(held->seam, 0);
  EXPECT_NEAR(held->speed_ratio, 0, 1e-6);
}

TEST(EvaluateAnticipate, NothingIsSaidOfWhatWasNotRecorded) {
  const Straight straight;
  const Table table = evaluate_one(
      straight.planted(),
      {straight.recording("a", "long", 90), straight.recording("b", "short", 40), straight.recording("c", "gone", 15)},
      {2, 1, 2, 1});
  EXPECT_EQ(table.left_out, (std::vector<std::string>{"gone"}));
  const Scores *both = row_of(table, "mean", "ours"), *brief = row_of(table, "short", "ours"),
               *lasting = row_of(table, "long", "ours");
  ASSERT_TRUE(both != nullptr && brief != nullptr && lasting != nullptr);
  // 40 frames: the window lies at 14, 26 frames are known.
  EXPECT_FALSE(std::isnan(brief->error[1]));
  EXPECT_TRUE(std::isnan(brief->error[3]) && std::isnan(brief->best_error[3]) && std::isnan(brief->root_error[3]));
  EXPECT_FALSE(std::isnan(brief->ndms[3])) << "NDMS needs no truth";
  EXPECT_TRUE(std::isnan(brief->npss));
  EXPECT_EQ(both->error[3], lasting->error[3]) << "the mean is over those that have one";
  EXPECT_NEAR(both->ndms[0], (brief->ndms[0] + lasting->ndms[0]) / 2, 1e-12);
  EXPECT_EQ(table.actions.back().windows, 2);

  const nlohmann::json json = table_json(table);
  EXPECT_EQ(json["horizons_seconds"].size(), 5U);
  EXPECT_EQ(json["left_out"], nlohmann::json({"gone"}));
  ASSERT_EQ(json["actions"].size(), 3U);
  EXPECT_EQ(json["actions"][0]["action"], "long");
  ASSERT_EQ(json["rows"].size(), 9U);
  EXPECT_EQ(json["rows"][5]["action"], "short");
  EXPECT_EQ(json["rows"][5]["method"], "ours");
  EXPECT_TRUE(json["rows"][5]["error_mm"]["1.6s"].is_null());
  EXPECT_EQ(json["rows"][5]["ndms"]["1.6s"], brief->ndms[3]);
  EXPECT_NO_THROW(nlohmann::json::parse(json.dump()));
  EXPECT_THAT(table_text(table), ::testing::HasSubstr("gone: no recording long enough"));
}

TEST(EvaluateAnticipate, EveryNetworkThatIsThereGivesItsRowAndTheSeedTheNumbers) {
  const auto recordings = people(70);
  Networks networks = untrained();
  const Evaluation options{3, 2, 0.8, 5};
  const Table table = evaluate_one(networks, recordings, options);
  std::vector<std::string> methods;
  for (const Scores& row : table.actions[0].rows) methods.push_back(row.method);
  EXPECT_EQ(methods, (std::vector<std::string>{"last pose held", "constant velocity", "memory alone", "seq2seq", "LTD",
                                               "HisRep", "VAE", "DLow", "Mix&Match", "Grammar", "ours"}));
  const Scores* ours = row_of(table, "walk", "ours");
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_GT(ours->apd[i], 0);
    EXPECT_GT(ours->best_error[i], 0);
    EXPECT_GT(ours->ndms[i], 0);
    EXPECT_LE(ours->ndms[i], 1);
  }
  EXPECT_EQ(table_json(evaluate_one(networks, recordings, options)).dump(), table_json(table).dump());
  Evaluation other = options;
  other.seed = 6;
  EXPECT_NE(row_of(evaluate_one(networks, recordings, other), "walk", "ours")->apd[1], ours->apd[1]);
  networks.pose = nullptr;
  networks.seq2seq = nullptr;
  EXPECT_EQ(evaluate_one(networks, recordings, options).actions[0].rows.size(), 9U);
  networks.memory = nullptr;
  EXPECT_EQ(evaluate_one(networks, recordings, options).actions[0].rows.size(), 8U);
  EXPECT_TRUE(evaluate_one(networks, people(12), options).actions.empty());
}

TEST(EvaluateAnticipate, ConstantVelocityAndRetrievalGoOnWhereMotionIsSteadyAndKnown) {
  const Straight straight;
  const auto test = straight.recording("a", "drift", 250);
  // Somebody else drifts likewise; the one who waves is no use to them, and nobody has ever been seen to rest.
  std::vector<Sequence> others = {straight.recording("b", "drift", 200)}, both = {test};
  for (Sequence& s : people(80)) others.push_back(s);
  both.push_back(straight.recording("c", "rest", 100));
  const Table table = evaluate_one(straight.planted(), both, {2, 3, 4, 1}, others);
  ASSERT_EQ(table.actions.size(), 2U) << "drift and the mean";
  ASSERT_EQ(table.apart.size(), 1U);
  EXPECT_EQ(table.apart[0].name, "rest");
  EXPECT_EQ(table.actions[0].training_words, 200 - 8 + 1);
  EXPECT_THAT(table_text(table), ::testing::HasSubstr("rest: no other recording"));
  const Scores *velocity = row_of(table, "mean", "constant velocity"), *memory = row_of(table, "mean", "retrieval"),
               *real = row_of(table, "mean", "real motion");
  ASSERT_TRUE(velocity != nullptr && memory != nullptr && real != nullptr);
  EXPECT_NEAR(velocity->ndms[9], 10.0 / 12, 2e-3);
  EXPECT_NEAR(velocity->error[9], 0, 0.5);
  EXPECT_NEAR(velocity->root_error[9], 0, 0.5);
  EXPECT_NEAR(memory->ndms[0], 10.0 / 12, 5e-2) << "seamless";
  EXPECT_NEAR(real->ndms[0], 10.0 / 12, 5e-2);
  EXPECT_NEAR(velocity->late_ratio, velocity->ndms[9] / real->ndms[9], 1e-2);
  EXPECT_NEAR(real->late_ratio, 1, 1e-9);
  EXPECT_EQ(row_of(table, "mean", "last pose held")->late_ratio, 0);
  EXPECT_EQ(table_json(table)["apart"], nlohmann::json({"rest"}));
}

TEST(EvaluateAnticipate, IntentionsAreComparedWithTheTransitionsOfTheRecordings) {
  // Two poses, which are the two labels.
  IntentionClusters clusters;
  clusters.poses = torch::zeros({2, kPoseFeatures});
  clusters.poses[1].fill_(1);
  const auto motion = [&](const std::vector<int64_t>& labels) {
    Tensor features = torch::zeros({static_cast<int64_t>(labels.size()), kFeatureCount});
    for (size_t t = 0; t < labels.size(); ++t)
      features[static_cast<int64_t>(t)].slice(0, 0, kPoseFeatures).copy_(clusters.poses[labels[t]]);
    return features;
  };
  const Tensor transitions =
      label_transitions({{"a", "x", motion({0, 0, 0, 1, 1})}, {"b", "x", motion({0})}}, clusters);
  EXPECT_LT((transitions - torch::tensor({2 / 3.0, 1 / 3.0, 0.0, 1.0}, torch::kDouble).view({2, 2}))
                .abs()
                .max()
                .item<double>(),
            1e-12);
  // From 0: 2/3 and then 4/9 stay there.
  const Tensor expected = expected_fractions(transitions, 0, 2);
  EXPECT_NEAR(expected[0].item<double>(), (2 / 3.0 + 4 / 9.0) / 2, 1e-12);
  EXPECT_NEAR(expected.sum().item<double>(), 1, 1e-12);
  const Tensor past = motion({0, 0, 1});
  EXPECT_EQ(last_label(past, clusters), 1);
  const Tensor fractions = label_fractions(past, torch::stack({motion({0, 1, 1, 1}), motion({0, 0, 1, 1})}), clusters);
  EXPECT_NEAR(fractions[0].item<double>(), 3 / 8.0, 1e-12);
  EXPECT_NEAR(fractions[1].item<double>(), 5 / 8.0, 1e-12);
}

TEST(EvaluateAnticipate, EveryRowSaysHowFarItsIntentionsAreFromTheRecordings) {
  const Table table = evaluate_one(untrained(), people(70), {3, 2, 0.8, 5}, people(60));
  for (const Scores& row : table.actions[0].rows) {
    if (row.method == "real motion") {
      EXPECT_TRUE(std::isnan(row.intentions));
      EXPECT_GT(row.seam, 0);
    } else {
      EXPECT_GE(row.intentions, 0) << row.method;
      EXPECT_LE(row.intentions, 1) << row.method;
    }
  }
  // Labels of another fold are others: two folds with labels of their own differ as one does.
  const Fold fold{untrained(), people(70), people(60)};
  const Table twice = evaluate({fold, fold}, {3, 2, 0.8, 5});
  for (const char* method : {"retrieval", "last pose held"})
    EXPECT_NEAR(row_of(twice, "walk", method)->intentions, row_of(table, "walk", method)->intentions, 1e-9) << method;
  // A fold that lacks a method says nothing of it, and its recordings are not expected of it.
  Fold without = fold;
  without.networks.seq2seq = nullptr;
  EXPECT_NEAR(row_of(evaluate({fold, without}, {3, 2, 0.8, 5}), "walk", "seq2seq")->intentions,
              row_of(table, "walk", "seq2seq")->intentions, 1e-9);
  const Scores* none = row_of(evaluate_one(untrained(), people(70), {3, 2, 0.8, 5}), "walk", "ours");
  EXPECT_TRUE(std::isnan(none->intentions)) << "without other recordings there is nothing to compare with";
  EXPECT_FALSE(std::isnan(none->seam));
}

TEST(EvaluateAnticipate, AMemoryAloneLeavesFromTheObservedPose) {
  const Networks n = untrained();
  const Tensor past = people(70)[0].features.slice(0, 0, 40) + 0.03, choice = torch::full({2, 30, 3}, 0.5F);
  const Tensor future = memory_future(*n.memory, past, choice);
  const Followed followed = n.memory->follow(past.unsqueeze(0), choice);
  EXPECT_LT((future[0][0] - past[39] - followed.changes[0][0]).abs().max().item<float>(), 2e-3);
  EXPECT_TRUE(torch::allclose(future.slice(1, 10), followed.features.slice(1, 10), 1e-6, 1e-6));
}

TEST(EvaluateAnticipate, FoldsCountAsOneAndOnlyTheirOwnDatabaseJudges) {
  const Straight straight;
  const std::vector<Sequence> a = {straight.recording("a", "drift", 120)}, b = people(120);
  const Evaluation options{2, 2, 1.2, 1};
  const Table one = evaluate_one(straight.planted(), a, options), other = evaluate_one(straight.planted(), b, options),
              both = evaluate({Fold{straight.planted(), a}, Fold{straight.planted(), b}}, options);
  EXPECT_EQ(both.actions.size(), 4U) << "drift, walk, wave and the mean";
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(row_of(both, "drift", "ours")->ndms[i], row_of(one, "drift", "ours")->ndms[i]);
    EXPECT_EQ(row_of(both, "walk", "ours")->ndms[i], row_of(other, "walk", "ours")->ndms[i]);
  }
  const Table twice = evaluate({Fold{straight.planted(), a}, Fold{straight.planted(), a}}, options);
  EXPECT_EQ(twice.actions[0].windows, 2 * one.actions[0].windows);
  EXPECT_NEAR(row_of(twice, "drift", "ours")->ndms[1], row_of(one, "drift", "ours")->ndms[1], 1e-12);
}

TEST(EvaluateAnticipate, TheFilesNdmsIsThatOfTheTable) {
  // Eval's row of real motion is the score of the training recordings. These people's hips rest exactly: turned as a
  // whole, what rounding leaves of their motion would be scored.
  const auto test = people(90);
  std::vector<Sequence> training = people(60);
  for (const WordKind kind : {WordKind::poses, WordKind::dlow, WordKind::package}) {
    Evaluation options{2, 2, 0.8, 1};
    options.words = kind;
    const Table table = evaluate_one(untrained(), test, options, training);
    std::vector<NamedMotion> motions, reference;
    const auto joints = [](const Sequence& s) {
      return feature_joints(s.features, torch::zeros({3}), torch::tensor(0.F));
    };
    for (const Sequence& s : training)
      if (s.action == "walk") motions.push_back({s.name, joints(s)});
    for (const Sequence& s : test)
      if (s.action == "walk") reference.push_back({s.name, joints(s)});
    NdmsOptions by;
    by.reference_stride = 1;
    by.words = kind;
    const NdmsScore score = score_ndms(motions, reference, by);
    const Scores* real = row_of(table, "walk", "real motion");
    ASSERT_NE(real, nullptr);
    EXPECT_NEAR(real->ndms[0], score.ndms, 1e-3);
    EXPECT_NEAR(real->coded[0], score.coded, 2e-2) << "sums of rounding tell there";
  }
}

TEST(Retrieval, GoesOnAsTheNearestRecordingDidAndBeginsWhereTheObservationEnds) {
  const auto recordings = people(100);
  const Retrieval memory({recordings[0], recordings[2]}, 8);
  // Somebody who walks as recording 0 did from frame 30 on.
  const Tensor past = recordings[0].features.slice(0, 0, 40), future = memory.future(past, 50);
  EXPECT_LT((future - recordings[0].features.slice(0, 40, 90)).abs().max().item<double>(), 1e-4);
  EXPECT_EQ(memory.future(past, 400).size(0), 400) << "past the end of the recording";
  // One who was never seen leaves without a jump.
  const Tensor other = recordings[1].features.slice(0, 0, 40) + 0.05, next = memory.future(other, 3);
  const double usual =
      (recordings[0].features.slice(0, 1) - recordings[0].features.slice(0, 0, -1)).abs().max().item<double>();
  EXPECT_LT((next[0] - other[-1]).slice(0, 0, 63).abs().max().item<double>(), 2 * usual);
  EXPECT_TRUE(Retrieval({}, 8).empty());
}

TEST(Validation, IsOfTheBestWherePlantedNetworksGoOnAsRecorded) {
  const Straight straight;
  Networks networks = straight.planted();
  const std::vector<Sequence> recordings = {straight.recording("a", "drift", 60)};
  EXPECT_NEAR(validation_ndms(networks, recordings), 10.0 / 12, 2e-3);
  const torch::NoGradGuard no_gradients;
  networks.seq2seq = Seq2SeqNetwork(networks.config);
  networks.seq2seq->out->weight.zero_();
  networks.seq2seq->out->bias.copy_(straight.change / networks.scale.deviation);
  EXPECT_NEAR(validation_error(networks, seq2seq_future, recordings), 0, 1e-3);
  networks.seq2seq->out->bias.zero_();  // the last pose held: the mean of 1 to 25 frames' motion
  EXPECT_NEAR(validation_error(networks, seq2seq_future, recordings), 13 * straight.mean_speed, 1e-3);
}

TEST(Validation, OfSeveralFuturesIsOfTheOneThatIsBestOverTheWholeSecond) {
  const Straight straight;
  const Networks networks = straight.planted();
  const std::vector<Sequence> recordings = {straight.recording("a", "drift", 60)};
  // The last pose held; a second one that leaves as recorded and comes back; a third as recorded, 1 mm off along z.
  const StochasticFutures futures = [](const Networks&, const Tensor& past, int64_t samples, int64_t frames, uint64_t) {
    const Tensor last = past[0][-1], step = last - past[0][-2], t = torch::arange(1, frames + 1).unsqueeze(1);
    Tensor off = torch::zeros({kFeatureCount});
    off.slice(0, 0, kPoseFeatures).view({21, 3}).select(1, 2).fill_(0.001);
    const Tensor held = last + 0 * t * step, returns = last + torch::where(t < frames / 2, t, frames - t) * step;
    return torch::stack({held, returns, last + t * step + off}).slice(0, 0, samples);
  };
  EXPECT_NEAR(nearest_validation_error(networks, futures, 1, recordings), 13 * straight.mean_speed, 1e-3);
  EXPECT_LT(nearest_validation_error(networks, futures, 2, recordings), 13 * straight.mean_speed - 0.01);
  EXPECT_NEAR(nearest_validation_error(networks, futures, 3, recordings), 0.001, 1e-4);
}

}  // namespace
}  // namespace inhabit::anticipate
