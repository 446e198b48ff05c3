#include "inhabit/interact/contacts_page.h"

#include <random>

#include "inhabit/scene/sampling.h"

namespace inhabit::interact {

Page contacts_page(const std::vector<HandContacts>& proposed, const Chair& chair, const Scene& scene) {
  constexpr int64_t kPaintedPoints = 6000;
  constexpr double kHeapRadius = 0.05;  // metres
  Page page;
  page.title = "Contacts on " + chair.name;
  page.note = "Red: where hands are proposed to touch.";
  page.scene = &scene;
  std::mt19937_64 random(1);
  const torch::Tensor points = sample_points(Scene{chair.name, {chair.mesh}, {}}, kPaintedPoints, random);
  torch::Tensor near = torch::zeros({1, 2, points.size(0)});
  for (const HandContacts& contacts : proposed)
    for (int64_t side = 0; side < 2; ++side)
      if (const auto& c = contacts[static_cast<size_t>(side)]) {
        const torch::Tensor far = (points - torch::tensor({c->x(), c->y(), c->z()}, torch::kFloat32)).norm(2, {1});
        near[0][side] = torch::max(near[0][side], (1 - far / kHeapRadius).clamp_min(0));
      }
  page.contacts = PageContacts{points, near, {"left hand", "right hand"}, 30, 0};
  return page;
}

}  // namespace inhabit::interact
