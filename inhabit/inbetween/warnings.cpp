#include "inhabit/inbetween/warnings.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace inhabit::inbetween {

std::vector<std::string> warnings_of(const Result& result, const std::vector<std::string>& contacts) {
  constexpr size_t kNamed = 5;
  constexpr double kMet = 0.03;
  std::vector<std::string> out;
  std::vector<Immersion> inside = result.key_immersions;
  std::stable_sort(inside.begin(), inside.end(), [](const auto& a, const auto& b) { return a.depth > b.depth; });
  if (!inside.empty()) {
    std::string where;
    for (size_t k = 0; k < std::min(inside.size(), kNamed); ++k)
      where +=
          fmt::format("{}{:.2f} s{}{}", k > 0 ? "; " : "", static_cast<double>(inside[k].frame) / result.motion.rate,
                      inside[k].depth > 0 ? ", " : "", inside[k].text());
    out.push_back(fmt::format("{} of {} key poses are inside the scene: at {}{}", inside.size(), result.keys.size(),
                              where, kNamed < inside.size() ? "; ..." : ""));
  }
  for (const int64_t key : result.unreached)
    out.push_back(fmt::format("no path around what stands before the key at {:.2f} s was found",
                              static_cast<double>(key) / result.motion.rate));
  for (size_t k = 0; k < result.contact_gaps.size(); ++k)
    if (result.contact_gaps[k] > kMet)
      out.push_back(fmt::format("{} is missed by {:.2f} m: places are in metres, within reach", contacts.at(k),
                                result.contact_gaps[k]));
  return out;
}

std::vector<std::string> notes_of(const Result& result) {
  std::vector<std::string> out;
  if (result.noise > 0)
    out.push_back(fmt::format("keys are taken to be off by {0:.1f} degrees and {0:.1f} cm (--noise)", result.noise));
  const std::string& name = result.scene.name;
  if (result.floor_assumed)
    out.emplace_back("no scene given: a flat floor under the feet is assumed");
  else if (result.scene.meshes.empty())
    out.push_back((name.empty() ? "scene" : name) + ": is a point cloud: where a body is inside it cannot be told");
  return out;
}

}  // namespace inhabit::inbetween
