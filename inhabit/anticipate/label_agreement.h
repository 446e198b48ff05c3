#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/anticipate/sample.h"

namespace inhabit::anticipate {

/// Normalised mutual information of two labellings (N) int64 of the same frames, in [0, 1]: 2 I(a, b) / (H(a) + H(b)).
/// Of two that never change 1.
double normalised_mutual_information(const torch::Tensor& a, const torch::Tensor& b);

/// How far two labellings of recordings, ours and another, agree with each other and with the actions' names. All are
/// normalised mutual information over the frames that both label, those of all recordings together.
struct LabelAgreement {
  double labels = 0;             ///< ours with the other
  double actions_and_other = 0;  ///< the names of the actions with the other
  double actions_and_ours = 0;   ///< the names of the actions with ours
  int64_t recordings = 0;        ///< that both label
  int64_t frames = 0;            ///< of these, which both label
};

/// Compares labels with those of an .npz file: an array for each recording, called "test/ACTION/NAME" for those of the
/// split "test" and "train/ACTION/NAME" for all others, with 120 labels a second.
/// @param recordings as sequences_of gives them; @param tracks (T) int64 our labels of each, `rate` a second.
/// Throws Error(path, ...) where the file has labels of none of the recordings or labels that are no whole numbers, and
/// what read_npz throws.
LabelAgreement label_agreement(const std::string& path, const std::vector<Sequence>& recordings,
                               const std::vector<torch::Tensor>& tracks, double rate);

}  // namespace inhabit::anticipate
