#pragma once
#include "inhabit/interact/evaluate.h"

namespace inhabit::interact {

/// Where hands touch chairs.
struct ContactScores {
  std::string contacts;  ///< "data", or whose draws
  int64_t chairs = 0;    ///< with a contact
  Estimate apd;          ///< Eq. 6, metres (distances, not their squares), interval over chairs
  Estimate touching;     ///< hands with a contact, of all hands of all sets
};

/// The contacts of trials beside `draws` that a model's ContactNet makes on each of their chairs, moved to the surface
/// (ChairInteractor::draw_contacts). Distances are between contacts of the same hand on the same chair, in the axes of
/// its seat.
std::vector<ContactScores> evaluate_contacts(const std::vector<Trial>& trials, const ChairInteractor& interactor,
                                             int64_t draws, uint64_t seed);

/// Where hands touch chairs as a table, a row each of `rows`: chairs, diversity (cm), hands with a contact (%).
ScoreTable score_table(const std::vector<ContactScores>& rows);

}  // namespace inhabit::interact
