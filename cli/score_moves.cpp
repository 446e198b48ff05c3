#include "inhabit/error.h"
#include "inhabit/inbetween/score_features.h"
#include "inhabit/io/shipped_model.h"
#include "score.h"

using namespace inhabit;
using Json = nlohmann::ordered_json;

namespace {

constexpr double kFeatureRate = 30;

std::vector<ScoredClip> over_floors(std::vector<ScoredClip> clips, const Scene& scene = {}) {
  for (ScoredClip& of : clips) of.clip = over_floor(of.clip, scene);
  return clips;
}

torch::Tensor features(Score& given, const std::vector<std::string>& named, const ClipReadOptions& reading) {
  static const auto network = inbetween::load_motion_autoencoder(model_file("", "motion-features.safetensors"));
  return inbetween::features_of(
      over_floors(score_clips(given, named, reading, kFeatureRate, inbetween::kFeatureFrames)), network);
}

}  // namespace

void score_skating_of(Score& given) {
  const Scene scene = read_scene(given.scene, given.notes);
  const auto clips = over_floors(score_clips(given, given.motion, given.reading, given.rate, 2), scene);
  const SkatingScore score = score_skating(clips);
  report_scores(given, {{"foot_skating", score.foot_skating},
                        {"motions", clips.size()},
                        {"files", rows_by_file(clips, [&](size_t i) {
                           return Json{{"foot_skating", score.by_clip[i]}};
                         })}});
}

void score_jerk_of(Score& given) {
  const auto clips = score_clips(given, given.motion, given.reading, given.rate, 4);
  const JerkScore score = score_jerk(clips);
  Json facts = {{"jerk", score.jerk}, {"acceleration", score.acceleration}, {"speed", score.speed}};
  if (!given.reference.empty())
    facts["jerk_ratio"] =
        score.jerk / score_jerk(score_clips(given, given.reference, given.reading_reference, given.rate, 4)).jerk;
  facts["motions"] = clips.size();
  facts["files"] = rows_by_file(clips, [&](size_t i) { return Json{{"jerk", score.by_clip[i]}}; });
  report_scores(given, facts);
}

void score_penetration_of(Score& given) {
  if (given.scene.file.empty()) throw Error("--scene", "is needed: what the body may be inside of");
  const Scene scene = read_scene(given.scene, given.notes);
  if (scene.meshes.empty()) throw Error(given.scene.file, "is a point cloud: where a body is inside it cannot be told");
  const auto clips = score_clips(given, given.motion, given.reading, given.rate);
  const PenetrationScore score = score_penetration(clips, scene);
  report_scores(given, {{"collision_frame_ratio", score.frame_ratio},
                        {"collision_vertex_ratio", score.vertex_ratio},
                        {"penetration_max_mm", score.penetration_max * 1000},
                        {"exact_collision_frame_ratio", score.exact_frame_ratio},
                        {"exact_collision_vertex_ratio", score.exact_vertex_ratio},
                        {"exact_penetration_max_mm", score.exact_penetration_max * 1000},
                        {"motions", clips.size()},
                        {"files", rows_by_file(clips, [&](size_t i) {
                           const auto& of = score.by_clip[i];
                           return Json{{"penetration_mm", of.depth * 1000},
                                       {"deepest_frame", of.frame},
                                       {"deepest_in", of.object},
                                       {"collision_frame_ratio", of.frame_ratio}};
                         })}});
}

void score_fid_of(Score& given) {
  const auto score = inbetween::score_fid(features(given, given.motion, given.reading),
                                          features(given, given.reference, given.reading_reference));
  report_scores(given, {{"fid", score.fid},
                        {"windows", score.windows},
                        {"reference_windows", score.reference_windows},
                        {"dimensions", score.dimensions}});
}

void score_diversity_of(Score& given) {
  const torch::Tensor own = features(given, given.motion, given.reading);
  Json facts = {{"diversity", inbetween::score_diversity(own)}, {"windows", own.size(0)}};
  if (!given.reference.empty()) {
    const torch::Tensor real = features(given, given.reference, given.reading_reference);
    facts["reference_diversity"] = inbetween::score_diversity(real);
    facts["reference_windows"] = real.size(0);
  }
  report_scores(given, facts);
}
