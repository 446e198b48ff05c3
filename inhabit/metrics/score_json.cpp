#include "inhabit/metrics/score_json.h"

namespace inhabit {

using Json = nlohmann::ordered_json;

Json score_json(const SkatingScore& score, const std::vector<ScoredClip>& clips) {
  return {{"foot_skating", score.foot_skating},
          {"motions", clips.size()},
          {"files", rows_by_file(clips, [&](size_t i) {
             return Json{{"foot_skating", score.by_clip[i]}};
           })}};
}

Json score_json(const JerkScore& score, const std::vector<ScoredClip>& clips, const JerkScore* reference) {
  Json out = {{"jerk", score.jerk}, {"acceleration", score.acceleration}, {"speed", score.speed}};
  if (reference != nullptr) out["jerk_ratio"] = score.jerk / reference->jerk;
  out["motions"] = clips.size();
  out["files"] = rows_by_file(clips, [&](size_t i) { return Json{{"jerk", score.by_clip[i]}}; });
  return out;
}

Json score_json(const PenetrationScore& score, const std::vector<ScoredClip>& clips) {
  return {{"collision_frame_ratio", score.frame_ratio},
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
           })}};
}

}  // namespace inhabit
