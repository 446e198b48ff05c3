#pragma once
#include <torch/types.h>

namespace inhabit {

/// Spectra that NPSS compares.
enum class NpssForm {
  published,  ///< squared magnitude, as Gopalakrishnan et al. (2019) define it
  real_part   ///< squared real part alone: LaFAN1's form, and that of code which copied the spectrum into real arrays
};

/// Normalised power spectrum similarity: the power of each feature of each sequence over the frequencies, normalised
/// and cumulated, L1 distance, averaged over sequences and features with the true power as weight. 0 is equal; lower is
/// better. Features that never change in truth or forecast carry no spectrum and are left out.
/// @param truth, forecast (B, T, D)
double npss(const torch::Tensor& truth, const torch::Tensor& forecast, NpssForm form = NpssForm::published);

/// What it is the ratio of, of each sequence: (B, 2) double, the distances times their weights and the weights, summed
/// over the features.
torch::Tensor npss_terms(const torch::Tensor& truth, const torch::Tensor& forecast,
                         NpssForm form = NpssForm::published);

}  // namespace inhabit
