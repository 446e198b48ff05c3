#include "inhabit/interact/interaction_page.h"

#include <spdlog/fmt/fmt.h>

namespace inhabit::interact {

Page interaction_page(const std::vector<Result>& results, const Scene& scene) {
  Page page;
  page.title = "Sitting on " + results.front().chair.name;
  page.note = "Handles: where the hands were to go.";
  page.scene = &scene;
  for (size_t i = 0; i < results.size(); ++i)
    page.people.push_back({results[i].motion, results.size() == 1 ? "motion" : fmt::format("sample {}", i + 1),
                           PagePerson::Role::motion});
  return page;
}

}  // namespace inhabit::interact
