#include "inhabit/error.h"
#include "inhabit/metrics/score_json.h"
#include "progress.h"
#include "score.h"

using namespace inhabit;

void score_ndms_of(Score& given) {
  NdmsOptions& options = given.ndms;
  options.rate = given.rate;
  const auto reference = score_clips(given, given.reference, given.reading_reference,
                                     options.rate * static_cast<double>(options.reference_stride));
  const auto motions =
      score_clips(given, given.motion, given.reading, options.rate, std::max(options.kappa, options.observed + 1));
  report_scores(given, score_json(score_ndms(motions, reference, options), motions));
}

void score_npss_of(Score& given) {
  const std::vector<std::string> truth = motion_files(given.truth), files = motion_files(given.motion);
  if (truth.size() != files.size()) throw Error("--truth", "one file for each of --motion is needed");
  std::vector<ScoredClip> motions, came;
  size_t next = 0;
  given.files = each_file(
      files,
      [&](const std::string& file) {
        const std::string& its_truth = truth[next++];
        const auto own = score_clips(given, file, given.reading, given.rate, 1);
        const auto true_ones = score_clips(given, its_truth, given.reading, given.rate, 1);
        motions.insert(motions.end(), own.begin(), own.end());
        came.insert(came.end(), true_ones.begin(), true_ones.end());
      },
      progress_of("files"));
  auto facts = begin_scores(ScoreKind::npss, score_npss(joints_of(motions), joints_of(came)));
  facts["sequences"] = motions.size();
  report_scores(given, facts);
}

void score_apd_of(Score& given) {
  const std::vector<NamedMotion> futures = joints_of(score_clips(given, given.motion, given.reading, given.rate));
  if (futures.size() < 2) throw Error("--motion", "APD needs two futures or more");
  const torch::Tensor apd = score_apd(futures);
  auto facts = begin_scores(ScoreKind::apd, apd.mean().item<double>());
  facts["sequence_apd_m"] = score_sequence_apd(futures);
  facts["futures"] = futures.size();
  facts["by_horizon"] = at_horizons(apd, given.rate);
  report_scores(given, facts);
}

void score_error_of(Score& given) {
  if (given.truth.size() != 1) throw Error("--truth", "one file is needed, the future that came true");
  const auto futures = joints_of(score_clips(given, given.motion, given.reading, given.rate));
  const auto truth = joints_of(score_clips(given, given.truth.front(), given.reading, given.rate, 1));
  report_scores(given, score_json(score_error(futures, truth), futures.size(), given.rate));
}
