#include "inhabit/metrics/score_json.h"

#include <cmath>

namespace inhabit {

using Json = nlohmann::ordered_json;

Json begin_scores(ScoreKind kind, double value) { return {{kScoreNames.at(static_cast<size_t>(kind)), value}}; }

Json at_horizons(const torch::Tensor& by_frame, double rate, double scale) {
  Json out = Json::array();
  for (const double horizon : {0.4, 0.8, 1.6, 2.0, 4.0, 10.0, 20.0, 30.0}) {
    const auto frame = static_cast<int64_t>(std::lround(horizon * rate)) - 1;
    if (frame < by_frame.size(0))
      out.push_back({{"seconds", horizon}, {"value", by_frame[frame].item<double>() * scale}});
  }
  return out;
}

Json score_json(const SkatingScore& score, const std::vector<ScoredClip>& clips) {
  Json out = begin_scores(ScoreKind::skating, score.foot_skating);
  out["motions"] = clips.size();
  out["files"] = rows_by_file(clips, [&](size_t i) { return Json{{"foot_skating", score.by_clip[i]}}; });
  return out;
}

Json score_json(const JerkScore& score, const std::vector<ScoredClip>& clips, const JerkScore* reference) {
  Json out = begin_scores(ScoreKind::jerk, score.jerk);
  out["acceleration"] = score.acceleration;
  out["speed"] = score.speed;
  if (reference != nullptr) out["jerk_ratio"] = score.jerk / reference->jerk;
  out["motions"] = clips.size();
  out["files"] = rows_by_file(clips, [&](size_t i) { return Json{{"jerk", score.by_clip[i]}}; });
  return out;
}

Json score_json(const PenetrationScore& score, const std::vector<ScoredClip>& clips) {
  Json out = begin_scores(ScoreKind::penetration, score.frame_ratio);
  out["collision_vertex_ratio"] = score.vertex_ratio;
  out["penetration_max_mm"] = score.penetration_max * 1000;
  out["exact_collision_frame_ratio"] = score.exact_frame_ratio;
  out["exact_collision_vertex_ratio"] = score.exact_vertex_ratio;
  out["exact_penetration_max_mm"] = score.exact_penetration_max * 1000;
  out["motions"] = clips.size();
  out["files"] = rows_by_file(clips, [&](size_t i) {
    const auto& of = score.by_clip[i];
    return Json{{"penetration_mm", of.depth * 1000},
                {"deepest_frame", of.frame},
                {"deepest_in", of.object},
                {"collision_frame_ratio", of.frame_ratio}};
  });
  return out;
}

Json score_json(const NdmsScore& score, const std::vector<ScoredClip>& clips) {
  Json out = begin_scores(ScoreKind::ndms, score.ndms);
  out["ndms_as_coded"] = score.coded;
  out["words"] = score.words;
  out["reference_words"] = score.reference_words;
  out["files"] = rows_by_file(clips, [&](size_t i) {
    const NdmsOfMotion& of = score.motions[i];
    return Json{{"ndms", of.ndms}, {"ndms_as_coded", of.coded}, {"words", of.words}, {"by_second", of.by_second}};
  });
  return out;
}

Json score_json(const MotionError& error, size_t futures, double rate) {
  Json out = begin_scores(ScoreKind::error, error.world.overall * 1000);
  out["path_error_mm"] = error.path.overall * 1000;
  out["pose_error_mm"] = error.pose.overall * 1000;
  out["best_of_n_world_mm"] = error.world.best_overall * 1000;
  out["best_of_n_mm"] = error.pose.best_overall * 1000;
  out["futures"] = futures;
  out["world_by_horizon_mm"] = at_horizons(error.world.mean, rate, 1000);
  out["path_by_horizon_mm"] = at_horizons(error.path.mean, rate, 1000);
  out["by_horizon_mm"] = at_horizons(error.pose.mean, rate, 1000);
  out["best_by_horizon_mm"] = at_horizons(error.pose.best, rate, 1000);
  return out;
}

}  // namespace inhabit
