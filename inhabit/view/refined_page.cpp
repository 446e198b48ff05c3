#include "inhabit/view/refined_page.h"

namespace inhabit {

Page refined_page(const Clip& before, const Clip& after, const Scene& scene, const std::string& title) {
  using Role = PagePerson::Role;
  Page page;
  page.title = title;
  page.note = "Grey: the motion as it was. Blue: as it was refined.";
  page.scene = &scene;
  page.people.push_back({before, "before", Role::past, 0, nullptr});
  page.people.push_back({after, "refined", Role::prediction, 0, nullptr});
  return page;
}

}  // namespace inhabit
