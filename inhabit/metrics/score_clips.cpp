#include "inhabit/metrics/score_clips.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "inhabit/body/body_model.h"
#include "inhabit/body/fit.h"
#include "inhabit/error.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/metrics/dynamics.h"
#include "inhabit/metrics/foot_skating.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/floor.h"
#include "inhabit/motion/local_pose.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/scene/floor.h"
#include "inhabit/scene/objects.h"

namespace inhabit {

ScoredClip scored_clip(const Clip& clip, double rate, int64_t least, const std::string& name) {
  ScoredClip out{name, retarget(resample(clip, rate, name), name), clip.rate};
  if (out.clip.frames() < least)
    throw Error(name, fmt::format("has {} frames at {:g} a second, {:.2f} s; {:.2f} s are needed", clip.frames(),
                                  clip.rate, clip.seconds(), static_cast<double>(least) / rate));
  return out;
}

std::vector<NamedMotion> joints_of(const std::vector<ScoredClip>& clips) {
  std::vector<NamedMotion> out;
  out.reserve(clips.size());
  for (const ScoredClip& of : clips) out.push_back({of.name, of.clip.joints});
  return out;
}

NdmsScore score_ndms(const std::vector<ScoredClip>& motions, const std::vector<ScoredClip>& reference,
                     const NdmsOptions& options) {
  if (reference.empty()) throw Error("reference", "holds no motion");
  const Skeleton& bones = reference.front().clip.skeleton;
  const auto on_bones = [&](const std::vector<ScoredClip>& clips) {
    std::vector<NamedMotion> out;
    out.reserve(clips.size());
    for (const ScoredClip& of : clips) out.push_back({of.name, on_skeleton(of.clip, bones).joints});
    return out;
  };
  return score_ndms(on_bones(motions), on_bones(reference), options);
}

Clip over_floor(const Clip& clip, const Scene& scene) {
  const double floor = scene.empty() ? floor_under(clip) : floor_under(clip, SceneQuery(scene));
  return transformed(clip, {0, {0, -floor, 0}});
}

std::vector<ScoredClip> over_floors(std::vector<ScoredClip> clips, const Scene& scene) {
  for (ScoredClip& of : clips) of.clip = over_floor(of.clip, scene);
  return clips;
}

SkatingScore score_skating(const std::vector<ScoredClip>& clips) {
  SkatingScore out;
  FootSkating all;
  for (const ScoredClip& of : clips) {
    const FootSkating found = foot_skating(of.clip);
    all.frames += found.frames;
    all.skating += found.skating;
    out.by_clip.push_back(found.fraction());
  }
  out.foot_skating = all.fraction();
  return out;
}

JerkScore score_jerk(const std::vector<ScoredClip>& clips) {
  JerkScore out;
  double frames = 0;
  for (const ScoredClip& of : clips) {
    const Dynamics moves = dynamics(of.clip);
    const auto count = static_cast<double>(moves.frames);
    out.jerk += count * moves.jerk;
    out.acceleration += count * moves.acceleration;
    out.speed += count * moves.speed;
    frames += count;
    out.by_clip.push_back(moves.jerk);
  }
  if (frames == 0) throw Error("jerk", "needs a motion of four frames or more");
  for (double* sum : {&out.jerk, &out.acceleration, &out.speed}) *sum /= frames;
  return out;
}

PenetrationScore score_penetration(const std::vector<ScoredClip>& clips, const Scene& given, const Progress& progress) {
  if (clips.empty()) throw Error("penetration", "needs a motion");
  PenetrationScore out;
  std::vector<torch::Tensor> roots;
  roots.reserve(clips.size());
  for (const ScoredClip& of : clips) roots.push_back(of.clip.root_path());
  const Scene scene = rooms_looking_in(given, torch::cat(roots));
  const CollisionMeter meter(builtin_body(), scene);
  double frames = 0;
  const auto all = static_cast<int64_t>(clips.size());
  for (const ScoredClip& of : clips) {
    if (progress) progress(static_cast<int64_t>(out.by_clip.size()), all);
    Clip clip = of.clip;
    if (!clip.betas.defined()) clip.betas = fit_shape(builtin_body(), clip.joints);
    const std::vector<Collision> found = meter.measure(clip, {CollisionTolerance{}, kNoTolerance});
    const auto count = static_cast<double>(clip.frames());
    out.frame_ratio += count * found[0].frame_ratio();
    out.vertex_ratio += count * found[0].vertex_ratio();
    out.exact_frame_ratio += count * found[1].frame_ratio();
    out.exact_vertex_ratio += count * found[1].vertex_ratio();
    out.penetration_max += found[0].penetration();
    out.exact_penetration_max += found[1].penetration();
    frames += count;
    PenetrationScore::OfClip own{found[0].penetration(), -1, found[0].frame_ratio(), ""};
    if (own.depth > 0) {
      const auto frame = found[0].depth.argmax().item<int64_t>();
      own.object = meter.nearest_objects(found[0].deepest.narrow(0, frame, 1))[0];
      own.frame = std::llround(static_cast<double>(frame) / clip.rate * of.file_rate);
    }
    out.by_clip.push_back(own);
  }
  if (progress) progress(all, all);
  for (double* sum : {&out.frame_ratio, &out.vertex_ratio, &out.exact_frame_ratio, &out.exact_vertex_ratio})
    *sum /= frames;
  for (double* sum : {&out.penetration_max, &out.exact_penetration_max}) *sum /= static_cast<double>(clips.size());
  return out;
}

}  // namespace inhabit
