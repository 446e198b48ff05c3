#include <cmath>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/metrics/score_motions.h"
#include "inhabit/motion/local_pose.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "outputs.h"
#include "verbs.h"
#include "word_kind.h"

namespace {

using namespace inhabit;

struct Score {
  std::vector<std::string> motion, reference, truth;
  std::string json;
  NdmsOptions ndms;
};

/// Every motion in the files on the standard skeleton at the score's rate. @param bones of whom; undefined: their own
std::vector<NamedMotion> standard_motions(const std::vector<std::string>& paths, double rate,
                                          const Skeleton& bones = {}) {
  std::vector<NamedMotion> out;
  for (const std::string& path : paths)
    for (const Clip& clip : read_clips(path)) {
      const Clip standard = retarget(resample(clip, rate, path), path);
      out.push_back({path, bones.size() == 0 ? standard.joints : on_skeleton(standard, bones).joints});
    }
  return out;
}

void report(const Score& given, nlohmann::ordered_json facts) {
  if (!given.json.empty()) write_atomically(given.json, facts.dump(1) + "\n");
  for (const auto& [key, value] : facts.items())
    if (!value.is_array()) std::printf("%s: %s\n", key.c_str(), value.dump().c_str());
}

nlohmann::ordered_json at_seconds(const torch::Tensor& by_frame, double rate, double scale) {
  nlohmann::ordered_json out;
  for (const double horizon : {0.4, 0.8, 1.6, 2.0, 4.0, 10.0, 20.0, 30.0}) {
    const auto frame = static_cast<int64_t>(std::lround(horizon * rate)) - 1;
    if (frame < by_frame.size(0))
      out.push_back({{"seconds", horizon}, {"value", by_frame[frame].item<double>() * scale}});
  }
  return out;
}

void report_ndms(const Score& given) {
  const NdmsOptions& options = given.ndms;
  // All on the bones of the first reference, as `eval anticipate` has them on those of the training data.
  const std::string& first = given.reference.front();
  const Skeleton bones = retarget(read_clips(first).front(), first).skeleton;
  const auto reference =
      standard_motions(given.reference, options.rate * static_cast<double>(options.reference_stride), bones);
  const NdmsScore score = score_ndms(standard_motions(given.motion, options.rate, bones), reference, options);
  nlohmann::ordered_json by_file = nlohmann::ordered_json::array();
  for (const NdmsOfMotion& of : score.motions)
    by_file.push_back({{"file", of.name},
                       {"ndms", of.ndms},
                       {"ndms_as_coded", of.coded},
                       {"words", of.words},
                       {"by_second", of.by_second}});
  report(given, {{"ndms", score.ndms},
                 {"ndms_as_coded", score.coded},
                 {"words", score.words},
                 {"reference_words", score.reference_words},
                 {"files", by_file}});
}

void report_npss(const Score& given) {
  if (given.truth.size() != given.motion.size()) throw Error("--truth", "one file for each of --motion is needed");
  const double rate = given.ndms.rate;
  const std::vector<NamedMotion> motions = standard_motions(given.motion, rate);
  report(given, {{"npss", score_npss(motions, standard_motions(given.truth, rate))}, {"sequences", motions.size()}});
}

void report_apd(const Score& given) {
  const std::vector<NamedMotion> futures = standard_motions(given.motion, given.ndms.rate);
  if (futures.size() < 2) throw Error("--motion", "APD needs two futures or more");
  const torch::Tensor apd = score_apd(futures);
  report(given, {{"apd_m", apd.mean().item<double>()},
                 {"sequence_apd_m", score_sequence_apd(futures)},
                 {"futures", futures.size()},
                 {"by_horizon", at_seconds(apd, given.ndms.rate, 1)}});
}

void report_error(const Score& given) {
  if (given.truth.size() != 1) throw Error("--truth", "one file is needed, the future that came true");
  const double rate = given.ndms.rate;
  const std::vector<NamedMotion> futures = standard_motions(given.motion, rate);
  const PoseError error = score_error(futures, standard_motions(given.truth, rate));
  report(given, {{"pose_error_mm", error.overall * 1000},
                 {"best_of_n_mm", error.best_overall * 1000},
                 {"futures", futures.size()},
                 {"by_horizon_mm", at_seconds(error.mean, rate, 1000)},
                 {"best_by_horizon_mm", at_seconds(error.best, rate, 1000)}});
}

}  // namespace

void add_score(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("score", "Measure any motion: NDMS, NPSS, APD, joint error");
  verb->require_subcommand(1);
  auto given = std::make_shared<Score>();
  const auto add = [&](const char* name, const char* what, void (*run)(const Score&)) {
    CLI::App* score = verb->add_subcommand(name, what);
    score->add_option("--motion", given->motion, "Motion files to score")->required();
    score->add_option("--rate", given->ndms.rate, "Frames a second to score at")
        ->check(frame_rate)
        ->capture_default_str();
    score->add_option("--json", given->json, "Also write the numbers as JSON");
    score->callback([given, run] {
      if (!given->json.empty()) require_writable(given->json);
      run(*given);
    });
    return score;
  };
  CLI::App* ndms =
      add("ndms", "Normalised directional motion similarity with real motion of the same kind", report_ndms);
  ndms->add_option("--reference", given->reference, "Real motion files that words are looked up in")->required();
  ndms->add_option("--observed", given->ndms.observed,
                   "Frames (at --rate) at the start of each motion that were observed")
      ->check(CLI::Range(0, 1000000));
  ndms->add_option("--kappa", given->ndms.kappa, "Frames of a motion word")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  add_word_kind(*ndms, given->ndms.words);
  add("npss", "Normalised power spectrum similarity with what came true", report_npss)
      ->add_option("--truth", given->truth, "What came true, a file for each motion")
      ->required();
  add("apd", "Average pairwise distance of several futures of one observation", report_apd);
  add("error", "Joint error of futures, their mean and the best of them", report_error)
      ->add_option("--truth", given->truth, "The future that came true")
      ->required();
}
