// Protects where proposed contacts are painted: within 5 cm of each, the nearer the redder, each hand by itself.
#include "inhabit/interact/contacts_page.h"

#include <gtest/gtest.h>

#include "interact/sitter.h"

namespace inhabit::interact {
namespace {

using torch::Tensor;

TEST(ContactsPage, PaintsAHeapAboutEachContact) {
  const Scene scene = seat_scene();
  const Chair chair = find_chair(scene, "chair_0");
  const Eigen::Vector3d front(0.1, 0.45, 0.25), side(0.25, 0.45, 0);
  const Page page = contacts_page({{front, std::nullopt}, {side, std::nullopt}}, chair, scene);
  EXPECT_EQ(page.title, "Contacts on chair_0");
  EXPECT_EQ(page.scene, &scene);
  ASSERT_TRUE(page.contacts.has_value());
  const Tensor& points = page.contacts->points;
  const Tensor& maps = page.contacts->maps;
  ASSERT_EQ(maps.sizes(), (std::vector<int64_t>{1, 2, points.size(0)}));
  const auto distance = [&](const Eigen::Vector3d& p) {
    return (points - torch::tensor({p.x(), p.y(), p.z()}, torch::kFloat32)).norm(2, {1});
  };
  const Tensor nearest = torch::min(distance(front), distance(side)), left = maps[0][0];
  EXPECT_TRUE(left.allclose((1 - nearest / 0.05).clamp_min(0), 0, 1e-5));
  EXPECT_GT(left.max().item<double>(), 0.5) << "points lie on the chair, and so do the contacts";
  EXPECT_EQ(maps[0][1].abs().max().item<double>(), 0) << "the right hand touches nothing";
}

}  // namespace
}  // namespace inhabit::interact
