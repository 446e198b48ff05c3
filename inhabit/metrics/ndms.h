#pragma once
#include "inhabit/metrics/motion_words.h"

namespace inhabit {

/// Forms of the similarity of two motion words.
enum class NdmsForm {
  equation,  ///< Eq. 11 and 12. A joint at rest in both words has no magnitude: 0
  coded,     ///< as the authors' training code computes it, which their tables come from as far as can be told: the
             ///< cosine counts as 1 where it is under 0.9999 and the components of the difference of both velocities
             ///< sum to less than 1e-6, which is so for about half of all joints. 0.04 to 0.14 above Eq. 12
  package    ///< Eq. 12 as the released package has it: lengths are floored at 1e-7, so that a joint at rest in both
             ///< words scores as floored vectors do: 1/2 (no direction, equal length)
};

/// Normalised directional motion similarity of words (N, kappa, J, 3), metres, with as many others: (N) in [0, 1].
/// Velocities are frame differences.
/// @param softness metres a frame; over 0 for training, since the score changes without bounds where joints hardly
/// move: a length l counts as sqrt(l^2 + softness^2), a joint at rest in both words still as 0, and numbers stay of the
/// words' own type, with finite gradients. 0: the score itself, float64
torch::Tensor ndms(const torch::Tensor& words, const torch::Tensor& others, NdmsForm form = NdmsForm::equation,
                   double softness = 0);

/// g of Eq. 10: (N) similarity of each word with the one nearest to it in the database, which no gradient goes through.
torch::Tensor plausibility(const torch::Tensor& words, const WordIndex& database, NdmsForm form = NdmsForm::equation,
                           double softness = 0);

/// The same in two forms, (N) each, of one search.
struct WordScores {
  torch::Tensor ndms;   ///< Eq. 12; with the package's floors for its words
  torch::Tensor coded;  ///< NdmsForm::coded
};
/// Similarity of words (N, kappa, J, 3), metres, each with the one nearest to it in the database.
/// @param kind whose words: decides which form WordScores::ndms is
WordScores word_scores(const torch::Tensor& words, const WordIndex& database, WordKind kind = WordKind::poses);

}  // namespace inhabit
