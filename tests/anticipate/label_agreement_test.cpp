// Protects what `inhabit intentions --compare` says: the closed forms of normalised mutual information, and which
// frames of which recordings are compared.
#include "inhabit/anticipate/label_agreement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "inhabit/io/npz.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

TEST(NormalisedMutualInformation, HasItsClosedForms) {
  const Tensor a = torch::tensor({0, 0, 1, 1}), renamed = torch::tensor({5, 5, 2, 2}),
               other = torch::tensor({0, 1, 0, 1});
  EXPECT_NEAR(normalised_mutual_information(a, renamed), 1, 1e-12);
  EXPECT_NEAR(normalised_mutual_information(a, other), 0, 1e-12);
  const int64_t most = std::numeric_limits<int64_t>::max();
  EXPECT_NEAR(normalised_mutual_information(a, torch::tensor({-1 - most, -1 - most, most, most})), 1, 1e-12)
      << "labels are names, whatever numbers they are";
  // Halves of halves: I = log 2, H = log 2 and log 4.
  EXPECT_NEAR(normalised_mutual_information(a, torch::arange(4)), 2.0 / 3, 1e-12);
}

Sequence labelled(const std::string& name, const std::string& action, const std::string& split) {
  Sequence out;
  out.name = name;
  out.action = action;
  out.split = split;
  return out;
}

/// Labels, each repeated as often as a file of 120 a second has it where ours are 30 a second.
Tensor four_times(const std::vector<int64_t>& labels) { return torch::tensor(labels).repeat_interleave(4); }

TEST(LabelAgreement, IsOverTheFramesOfAllRecordingsThatBothLabel) {
  const TempFolder folder;
  const std::string path = folder / "labels.npz";
  Npz theirs;
  theirs.tensors["train/walk/a"] = four_times({0, 0, 1, 1});
  theirs.tensors["train/wave/b"] = four_times({2, 2}).to(torch::kInt32);  // shorter than ours
  theirs.tensors["test/walk/c"] = four_times({1, 1});
  theirs.tensors["train/walk/d"] = four_times({3, 3});  // of nobody here
  write_npz(path, theirs);
  const std::vector<Sequence> recordings = {labelled("a", "walk", "train"), labelled("b", "wave", "val"),
                                            labelled("c", "walk", "test"), labelled("e", "wave", "test")};
  const std::vector<Tensor> renamed = {torch::tensor({4, 4, 0, 0}), torch::tensor({1, 1, 5, 5}), torch::tensor({0, 0}),
                                       torch::tensor({7, 7})};
  const LabelAgreement agreement = label_agreement(path, recordings, renamed, 30);
  EXPECT_EQ(agreement.recordings, 3);
  EXPECT_EQ(agreement.frames, 4 + 2 + 2);
  EXPECT_NEAR(agreement.labels, 1, 1e-12) << "the same labels by other numbers";
  // Of eight frames six are walked; the labels are of two, four and two frames and tell the action:
  // I = H(action) = log 4 - 3/4 log 3, H(labels) = 3/2 log 2.
  const double action = std::log(4.0) - 0.75 * std::log(3.0), labels = 1.5 * std::log(2.0);
  EXPECT_NEAR(agreement.actions_and_other, 2 * action / (action + labels), 1e-12);
  EXPECT_NEAR(agreement.actions_and_ours, agreement.actions_and_other, 1e-12);
}

TEST(LabelAgreement, TakesTheLabelAtEachFramesTime) {
  const TempFolder folder;
  const std::string path = folder / "labels.npz";
  Npz theirs;
  theirs.tensors["train/walk/a"] = torch::arange(120);
  write_npz(path, theirs);
  // At 50 a second frames stand at 0, 2.4, 4.8, 7.2 and 9.6 of theirs.
  const std::vector<Tensor> tracks = {torch::tensor({0, 0, 1, 1, 1})};
  const LabelAgreement agreement = label_agreement(path, {labelled("a", "walk", "train")}, tracks, 50);
  EXPECT_EQ(agreement.frames, 5);
  // Five labels of theirs, each seen once: I = H(ours).
  const double ours = std::log(5.0) - (2 * std::log(2.0) + 3 * std::log(3.0)) / 5, other = std::log(5.0);
  EXPECT_NEAR(agreement.labels, 2 * ours / (ours + other), 1e-12);
  EXPECT_NEAR(agreement.actions_and_ours, 0, 1e-12) << "one action says nothing";
}

TEST(LabelAgreement, RefusesLabelsOfOtherRecordings) {
  const TempFolder folder;
  const std::string path = folder / "labels.npz";
  Npz theirs;
  theirs.tensors["train/walk/a"] = four_times({0, 0});
  write_npz(path, theirs);
  const std::vector<Tensor> tracks = {torch::tensor({0, 0})};
  EXPECT_THAT(refusal_of([&] { label_agreement(path, {labelled("a", "walk", "test")}, tracks, 30); }),
              ::testing::HasSubstr("labels.npz: has labels of none of the recordings"));
}

TEST(LabelAgreement, RefusesWhatIsNoListOfWholeNumbers) {
  const TempFolder folder;
  const std::string path = folder / "labels.npz";
  const auto refused = [&](const Tensor& labels) {
    Npz theirs;
    theirs.tensors["train/walk/a"] = labels;
    write_npz(path, theirs);
    return refusal_of([&] { label_agreement(path, {labelled("a", "walk", "train")}, {torch::tensor({0, 0})}, 30); });
  };
  EXPECT_EQ(refused(four_times({-1, 7})), "");
  EXPECT_EQ(refused(four_times({-1, 7}).to(torch::kFloat32)), "");
  for (const Tensor& labels : {torch::tensor(3), torch::zeros({8, 2}), torch::full({8}, 0.5), torch::full({8}, NAN),
                               torch::full({8}, 1e300, torch::kFloat64)})
    EXPECT_THAT(refused(labels), ::testing::HasSubstr("labels.npz: train/walk/a is no list of whole numbers"))
        << labels;
}

}  // namespace
}  // namespace inhabit::anticipate
