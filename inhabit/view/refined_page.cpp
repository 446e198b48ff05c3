#include "inhabit/view/refined_page.h"

namespace inhabit {
namespace {

/// Strips that say when hands are in contact; none where they never are.
std::vector<PageTrack> hand_tracks(const Clip& clip) {
  std::vector<PageTrack> out;
  if (!clip.hand_targets.defined()) return out;
  for (const int side : {0, 1}) {
    const torch::Tensor on = clip.hand_targets.select(1, side).select(1, 3).gt(0.5);
    if (on.any().item<bool>())
      out.push_back({side == 0 ? "left hand" : "right hand", {}, on.to(torch::kInt64) - 1, {"in contact"}});
  }
  return out;
}

}  // namespace

Page refined_page(const std::vector<RefinedPerson>& people, const Scene& scene, const std::string& title) {
  using Role = PagePerson::Role;
  Page page;
  page.title = title;
  page.note = "Grey: the motion as it was. Blue: as it was refined.";
  page.scene = &scene;
  for (size_t i = 0; i < people.size(); ++i) {
    const std::string number = people.size() > 1 ? " " + std::to_string(i + 1) : "";
    page.people.push_back({people[i].before, "before" + number, Role::past, 0, nullptr});
    page.people.push_back({people[i].after, "refined" + number, Role::prediction, 0, nullptr});
    page.people.back().tracks = hand_tracks(people[i].after);
  }
  return page;
}

}  // namespace inhabit
