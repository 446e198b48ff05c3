#include "inhabit/inbetween/inbetween_page.h"

#include <spdlog/fmt/fmt.h>

#include "inhabit/inbetween/keyframes.h"

namespace inhabit::inbetween {

Page inbetween_page(const std::vector<Result>& results, bool cleaned, const torch::Tensor& key_groups,
                    const std::string& title) {
  const Result& first = results.front();
  Page page;
  page.title = title;
  page.note = std::string("Blue: key poses. Purple: filled in. Prints on the floor: where a foot stands. ") +
              (first.scene.meshes.empty() ? "The scene is points, which have no inside."
                                          : "Red: the body is inside the scene.");
  page.scene = &first.scene;
  for (size_t s = 0; s < results.size(); ++s) {
    PagePerson person{results[s].motion, results.size() == 1 ? "filled in" : fmt::format("sample {}", s + 1),
                      PagePerson::Role::filled};
    person.keys = first.keys;
    if (cleaned || key_groups.defined()) person.given = first.key_poses;
    person.given_joints = key_joints_of(key_groups);
    person.collides = results[s].collides;
    for (const Immersion& in : results[s].immersions) person.collides_with.push_back(in.text());
    page.people.push_back(person);
  }
  return page;
}

}  // namespace inhabit::inbetween
