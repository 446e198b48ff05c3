#pragma once
#include <string>
#include <vector>

#include "inhabit/train/loop.h"

namespace inhabit {

// A system's training is one or more stages that fill one model file, `out`. Its log is `out`.log.jsonl; where an
// interrupted run goes on, whichever stage it was in, is `out`.checkpoint.safetensors.

/// Which of `stages` (task names) a run starts with: the first, or, resumed, that of the checkpoint. Throws Error where
/// there is no checkpoint or it is of another stage.
size_t first_stage(const std::string& out, const std::vector<std::string>& stages, bool resume);

/// Options of stage number `stage` with these files; steps, batch and rate are the system's to fill in.
TrainOptions stage_options(const std::string& out, size_t stage, size_t first, bool resume);

}  // namespace inhabit
