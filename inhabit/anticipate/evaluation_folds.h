#pragma once
#include <string>
#include <utility>
#include <vector>

#include "inhabit/anticipate/evaluate.h"
#include "inhabit/io/read_options.h"

namespace inhabit::anticipate {

/// What an evaluation on recordings of labelled actions goes over: each model with the recordings that it is measured
/// on and those that it may remember.
/// @param data cmu:FOLDER, h36m:FOLDER or a native data set folder. @param split train, val or test: of one model; or
/// left-out: each recording but those of test, for models that were trained without it (training.folds), one for each
/// fold; without models, for rows that need no training, each recording by itself. @param models with their files'
/// names; a memory forgets the validation recordings where `split` is val. @param config of rows without models (their
/// memory's settings). Throws Error that names the file or the data at fault.
std::vector<Fold> evaluation_folds(const std::string& data, const std::string& split,
                                   const std::vector<std::pair<std::string, Networks>>& models,
                                   const Config& config = {}, Notes* notes = nullptr);

}  // namespace inhabit::anticipate
