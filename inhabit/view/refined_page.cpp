#include "inhabit/view/refined_page.h"

namespace inhabit {

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
  }
  return page;
}

}  // namespace inhabit
