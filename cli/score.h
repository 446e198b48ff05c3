#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inhabit/metrics/score_clips.h"
#include "inhabit/metrics/score_motions.h"
#include "inputs.h"

/// What a verb of `score` is asked for, and what it meets on the way.
struct Score {
  std::vector<std::string> motion, reference, truth;
  inhabit::ClipReadOptions reading, reading_reference;
  SceneInput scene;
  std::string json;
  double rate = 25;
  inhabit::NdmsOptions ndms;
  inhabit::Notes notes;
  inhabit::FileCount files;  ///< of all kinds together
};

/// Every motion in a file as scores take it. @param least frames at `rate` that are needed
std::vector<inhabit::ScoredClip> score_clips(Score& given, const std::string& file,
                                             const inhabit::ClipReadOptions& reading, double rate, int64_t least);

/// Those in files, folders and patterns; what cannot be used is skipped and counted in Score::files.
std::vector<inhabit::ScoredClip> score_clips(Score& given, const std::vector<std::string>& named,
                                             const inhabit::ClipReadOptions& reading, double rate, int64_t least = 1);

/// Writes the JSON that is asked for and prints what is no list.
void report_scores(const Score& given, nlohmann::ordered_json facts);

// Each measures and reports.
void score_ndms_of(Score& given);
void score_npss_of(Score& given);
void score_apd_of(Score& given);
void score_error_of(Score& given);
void score_fid_of(Score& given);
void score_skating_of(Score& given);
void score_jerk_of(Score& given);
void score_penetration_of(Score& given);
void score_diversity_of(Score& given);
