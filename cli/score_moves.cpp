#include "inhabit/error.h"
#include "inhabit/inbetween/score_features.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/metrics/score_json.h"
#include "progress.h"
#include "score.h"

using namespace inhabit;

namespace {

constexpr double kFeatureRate = 30;

torch::Tensor features(Score& given, const std::vector<std::string>& named, const ClipReadOptions& reading) {
  static const auto network = inbetween::load_motion_autoencoder(model_file("", "motion-features.safetensors"));
  return inbetween::features_of(
      over_floors(score_clips(given, named, reading, kFeatureRate, inbetween::kFeatureFrames)), network);
}

}  // namespace

void score_skating_of(Score& given) {
  const Scene scene = read_scene(given.scene, given.notes);
  const auto clips = over_floors(score_clips(given, given.motion, given.reading, given.rate, 2), scene);
  report_scores(given, score_json(score_skating(clips), clips));
}

void score_jerk_of(Score& given) {
  const auto clips = score_clips(given, given.motion, given.reading, given.rate, 4);
  const JerkScore score = score_jerk(clips);
  if (given.reference.empty()) return report_scores(given, score_json(score, clips));
  const JerkScore reference = score_jerk(score_clips(given, given.reference, given.reading_reference, given.rate, 4));
  report_scores(given, score_json(score, clips, &reference));
}

void score_penetration_of(Score& given) {
  if (given.scene.file.empty()) throw Error("--scene", "is needed: what the body may be inside of");
  const Scene scene = read_scene(given.scene, given.notes);
  if (scene.meshes.empty()) throw Error(given.scene.file, "is a point cloud: where a body is inside it cannot be told");
  const auto clips = score_clips(given, given.motion, given.reading, given.rate);
  report_scores(given, score_json(score_penetration(clips, scene, progress_of("motions")), clips));
}

void score_fid_of(Score& given) {
  const auto score = inbetween::score_fid(features(given, given.motion, given.reading),
                                          features(given, given.reference, given.reading_reference));
  auto facts = begin_scores(ScoreKind::fid, score.fid);
  facts["windows"] = score.windows;
  facts["reference_windows"] = score.reference_windows;
  facts["dimensions"] = score.dimensions;
  report_scores(given, facts);
}

void score_diversity_of(Score& given) {
  const torch::Tensor own = features(given, given.motion, given.reading);
  auto facts = begin_scores(ScoreKind::diversity, inbetween::score_diversity(own));
  facts["windows"] = own.size(0);
  if (!given.reference.empty()) {
    const torch::Tensor real = features(given, given.reference, given.reading_reference);
    facts["reference_diversity"] = inbetween::score_diversity(real);
    facts["reference_windows"] = real.size(0);
  }
  report_scores(given, facts);
}
