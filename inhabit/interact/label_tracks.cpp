#include "inhabit/interact/label_tracks.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "inhabit/interact/labels.h"
#include "inhabit/interact/seated.h"

namespace inhabit::interact {
namespace {

/// Stretches of one contact each, from (T, 4) targets.
PageTrack contact_track(const std::string& name, const torch::Tensor& targets) {
  PageTrack out{name, {}, torch::full({targets.size(0)}, -1, torch::kInt64), {}};
  const torch::Tensor rows = targets.to(torch::kFloat).contiguous();
  const auto at = rows.accessor<float, 2>();
  int64_t* label = out.labels.data_ptr<int64_t>();
  for (int64_t t = 0; t < rows.size(0); ++t) {
    if (at[t][3] < 0.5F) continue;
    const std::string place = fmt::format("{:.2f} {:.2f} {:.2f}", at[t][0], at[t][1], at[t][2]);
    const auto known = std::find(out.names.begin(), out.names.end(), place);
    label[t] = known - out.names.begin();
    if (known == out.names.end()) out.names.push_back(place);
  }
  return out;
}

}  // namespace

std::vector<PageTrack> label_tracks(const Clip& clip) {
  if (clip.skeleton.size() != kStandardJoints || !clip.contact.defined() || clip.frames() == 0) return {};
  const bool touches = clip.hand_targets.defined() && clip.hand_targets.select(2, 3).gt(0.5).any().item<bool>();
  if (!touches && stays_of(clip).empty()) return {};
  // Only goals depend on the chair, and they are not shown.
  const Labels labels = label(clip, Chair{});
  return {{"left hand", labels.hand_phase.select(1, 0)},
          {"right hand", labels.hand_phase.select(1, 1)},
          {"phase", labels.global_phase - labels.global_phase.floor()},
          {"action", {}, labels.action.argmax(1), kActionNames},
          contact_track("left contact", labels.hand_target.select(1, 0)),
          contact_track("right contact", labels.hand_target.select(1, 1))};
}

}  // namespace inhabit::interact
