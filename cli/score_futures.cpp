#include <cmath>

#include "inhabit/error.h"
#include "inhabit/metrics/score_json.h"
#include "progress.h"
#include "score.h"

using namespace inhabit;
using Json = nlohmann::ordered_json;

namespace {

Json at_seconds(const torch::Tensor& by_frame, double rate, double scale) {
  Json out = Json::array();
  for (const double horizon : {0.4, 0.8, 1.6, 2.0, 4.0, 10.0, 20.0, 30.0}) {
    const auto frame = static_cast<int64_t>(std::lround(horizon * rate)) - 1;
    if (frame < by_frame.size(0))
      out.push_back({{"seconds", horizon}, {"value", by_frame[frame].item<double>() * scale}});
  }
  return out;
}

}  // namespace

void score_ndms_of(Score& given) {
  NdmsOptions& options = given.ndms;
  options.rate = given.rate;
  const auto reference = score_clips(given, given.reference, given.reading_reference,
                                     options.rate * static_cast<double>(options.reference_stride));
  const auto motions =
      score_clips(given, given.motion, given.reading, options.rate, std::max(options.kappa, options.observed + 1));
  const NdmsScore score = score_ndms(motions, reference, options);
  report_scores(
      given,
      {{"ndms", score.ndms},
       {"ndms_as_coded", score.coded},
       {"words", score.words},
       {"reference_words", score.reference_words},
       {"files", rows_by_file(motions, [&](size_t i) {
          const NdmsOfMotion& of = score.motions[i];
          return Json{{"ndms", of.ndms}, {"ndms_as_coded", of.coded}, {"words", of.words}, {"by_second", of.by_second}};
        })}});
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
  report_scores(given, {{"npss", score_npss(joints_of(motions), joints_of(came))}, {"sequences", motions.size()}});
}

void score_apd_of(Score& given) {
  const std::vector<NamedMotion> futures = joints_of(score_clips(given, given.motion, given.reading, given.rate));
  if (futures.size() < 2) throw Error("--motion", "APD needs two futures or more");
  const torch::Tensor apd = score_apd(futures);
  report_scores(given, {{"apd_m", apd.mean().item<double>()},
                        {"sequence_apd_m", score_sequence_apd(futures)},
                        {"futures", futures.size()},
                        {"by_horizon", at_seconds(apd, given.rate, 1)}});
}

void score_error_of(Score& given) {
  if (given.truth.size() != 1) throw Error("--truth", "one file is needed, the future that came true");
  const auto futures = joints_of(score_clips(given, given.motion, given.reading, given.rate));
  const auto truth = joints_of(score_clips(given, given.truth.front(), given.reading, given.rate, 1));
  const MotionError error = score_error(futures, truth);
  const auto horizons = [&](const torch::Tensor& metres) { return at_seconds(metres, given.rate, 1000); };
  report_scores(given, {{"world_error_mm", error.world.overall * 1000},
                        {"path_error_mm", error.path.overall * 1000},
                        {"pose_error_mm", error.pose.overall * 1000},
                        {"best_of_n_world_mm", error.world.best_overall * 1000},
                        {"best_of_n_mm", error.pose.best_overall * 1000},
                        {"futures", futures.size()},
                        {"world_by_horizon_mm", horizons(error.world.mean)},
                        {"path_by_horizon_mm", horizons(error.path.mean)},
                        {"by_horizon_mm", horizons(error.pose.mean)},
                        {"best_by_horizon_mm", horizons(error.pose.best)}});
}
