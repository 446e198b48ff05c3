#pragma once
#include <string>
#include <vector>

#include "inhabit/io/safetensors.h"

namespace inhabit {

/// The weighted mean of models that one training went through, or that trainings from the same weights ended in: their
/// mean often generalises better than each ("model soups", Wortsman et al. 2022). Types of numbers and metadata are
/// those of the first, and so are the stays of recorded people (interact/habits.h); how they were trained may differ.
/// It has no FootContactNet (inbetween/foot_contact_net.h), which is to be trained on it anew.
/// @param weights one for each, not negative; they need not sum to 1. Throws Error naming the file that has other
/// tensors, another configuration or numbers that are not finite; a setting that came after one of the files was
/// written does not count.
SafeTensors mean_of_models(const std::vector<std::string>& paths, const std::vector<double>& weights);

}  // namespace inhabit
