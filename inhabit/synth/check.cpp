#include "inhabit/synth/check.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "inhabit/body/body_model.h"
#include "inhabit/each_item.h"
#include "inhabit/metrics/dynamics.h"
#include "inhabit/metrics/foot_skating.h"
#include "inhabit/metrics/penetration.h"

namespace inhabit {
namespace {

constexpr int64_t kLeastWalk = 15;  // frames; shorter walks are steps in place

struct Measures {
  FootSkating skating;
  Dynamics walk;
  LimitExcess limits;
  Penetration depth;
  HandContact hands;
};

Measures measure(const Dataset& dataset, const DatasetClip& entry, const BodyModel& body) {
  Measures out;
  const Clip clip = load_clip(dataset, entry);
  out.skating = foot_skating(clip);
  out.walk = dynamics(clip, frames_of_action(clip, "walk"));
  if (!clip.rotations.defined() || clip.skeleton.size() < kStandardJoints) return out;
  out.limits = beyond_limits(clip, body);
  if (entry.scene.empty()) return out;
  const Scene scene = load_scene(dataset, entry.scene);
  out.depth = deepest_penetration(clip, body, scene);
  out.hands = hand_contact(clip, body, scene);
  return out;
}

}  // namespace

std::vector<Bar> check_motion(const Dataset& dataset, const std::string& split, const Progress& progress) {
  const std::vector<DatasetClip> clips = dataset.split(split);
  const BodyModel& body = builtin_body();
  std::vector<Measures> measures(clips.size());
  each_item(static_cast<int64_t>(clips.size()), progress, [&](int64_t i) {
    measures[static_cast<size_t>(i)] = measure(dataset, clips[static_cast<size_t>(i)], body);
  });

  std::vector<Bar> bars;
  // A mean over frames: clips weigh by their number of frames.
  auto mean_bar = [&](const char* name, const char* unit, double low, double high, auto value, auto weight) {
    Bar bar;
    bar.name = name, bar.unit = unit, bar.low = low, bar.high = high;
    double total = 0, farthest = -1e300;
    for (size_t i = 0; i < clips.size(); ++i) {
      const double w = static_cast<double>(weight(measures[i])), v = value(measures[i]);
      if (w <= 0) continue;
      ++bar.clips;
      bar.value += w * v;
      total += w;
      const double out = low > 0 ? std::max(low - v, v - high) : v - high;
      if (out > farthest) farthest = out, bar.worst = v, bar.worst_clip = clips[i].file;
    }
    if (total > 0) bar.value /= total;
    bars.push_back(bar);
  };
  const auto place = [](int joint, const std::string& object, int64_t frame) {
    return standard_joint_names()[static_cast<size_t>(joint)] + object + ", frame " + std::to_string(frame);
  };
  auto worst_bar = [&](const char* name, const char* unit, double high, auto value, auto there, auto where) {
    Bar bar;
    bar.name = name, bar.unit = unit, bar.high = high;
    for (size_t i = 0; i < clips.size(); ++i) {
      if (!there(measures[i])) continue;
      const double v = value(measures[i]);
      if (bar.clips++ == 0 || v > bar.value) {
        bar.value = bar.worst = v;
        bar.worst_clip = clips[i].file;
        bar.where = v > 0 ? where(measures[i]) : "";
      }
    }
    bars.push_back(bar);
  };
  const auto walked = [](const Measures& m) { return m.walk.frames >= kLeastWalk ? m.walk.frames : 0; };
  const auto any = [](const Measures&) { return true; };
  const auto touched = [](const Measures& m) { return m.hands.contacts > 0; };
  mean_bar(
      "foot skating", "of frames", 0, 0.03, [](const Measures& m) { return m.skating.fraction(); },
      [](const Measures& m) { return m.skating.frames; });
  mean_bar(
      "walking speed", "m/s", 0.6, 1.5, [](const Measures& m) { return m.walk.speed; }, walked);
  mean_bar(
      "joint acceleration while walking", "m/s^2", 6, 14, [](const Measures& m) { return m.walk.acceleration; },
      walked);
  mean_bar(
      "joint jerk while walking", "m/s^3", 220, 560, [](const Measures& m) { return m.walk.jerk; }, walked);
  worst_bar(
      "beyond joint limits", "rad", 1e-3, [](const Measures& m) { return m.limits.radians; }, any,
      [&](const Measures& m) { return place(m.limits.joint, "", m.limits.frame); });
  worst_bar(
      "depth in walls and furniture", "m", 0.02, [](const Measures& m) { return m.depth.depth; }, any,
      [&](const Measures& m) { return place(m.depth.joint, " in " + m.depth.object, m.depth.frame); });
  worst_bar(
      "hand contact point to surface", "m", 0.01, [](const Measures& m) { return m.hands.target_gap; }, touched,
      [](const Measures&) { return std::string(); });
  worst_bar(
      "touching hand to surface", "m", 0.01, [](const Measures& m) { return m.hands.hand_gap; }, touched,
      [](const Measures&) { return std::string(); });
  return bars;
}

std::string bars_text(const std::vector<Bar>& bars) {
  std::string out =
      fmt::format("{:<34} {:>10} {:>10} {:>10}  {:<5} {}\n", "", "low", "measured", "high", "", "worst clip");
  for (const Bar& bar : bars) {
    if (bar.clips == 0) {
      out += fmt::format("{:<34} {:>10g} {:>10} {:>10g}  -     no clip has any\n", bar.name, bar.low, "-", bar.high);
      continue;
    }
    const std::string where = bar.where.empty() ? "" : ", " + bar.where;
    out += fmt::format("{:<34} {:>10g} {:>10.4g} {:>10g}  {:<5} {} ({:.4g} {}{})\n", bar.name, bar.low, bar.value,
                       bar.high, bar.pass() ? "pass" : "FAIL", bar.worst_clip, bar.worst, bar.unit, where);
  }
  return out;
}

nlohmann::json bars_json(const std::vector<Bar>& bars) {
  nlohmann::json out = nlohmann::json::array();
  for (const Bar& bar : bars)
    out.push_back({{"name", bar.name},
                   {"unit", bar.unit},
                   {"low", bar.low},
                   {"high", bar.high},
                   {"value", bar.value},
                   {"clips", bar.clips},
                   {"pass", bar.pass()},
                   {"worst", bar.worst},
                   {"worst_clip", bar.worst_clip},
                   {"where", bar.where}});
  return out;
}

}  // namespace inhabit
