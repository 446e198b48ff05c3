// Protects ContactNet: trained on two chairs it puts hands where they belong.
#include "inhabit/interact/contact_network.h"

#include <gtest/gtest.h>

#include "interact/small_networks.h"
#include "largest.h"

namespace inhabit::interact {
namespace {

using torch::Tensor;

TEST(ContactNetwork, HasThePapersSizes) {
  const ContactNetwork network(preset("paper"));
  const auto p = network->named_parameters();
  EXPECT_EQ(p["encoder.cond_encoder1.0.weight"].sizes(), at::IntArrayRef({512, 2048}));
  EXPECT_EQ(p["encoder.cond_encoder1.4.weight"].sizes(), at::IntArrayRef({64, 512}));
  EXPECT_EQ(p["encoder.fc2.weight"].size(0), 6);
  EXPECT_EQ(p["decoder.main.0.weight"].size(1), 6 + 64);
}

TEST(ContactNetwork, LearnsWhereHandsGoOnEachChair) {
  torch::manual_seed(5);
  Config c = small_interact_config();
  ContactNetwork network(c);
  const Tensor chairs = torch::rand({2, c.chair_size()});
  // On the first chair hands rest at +-0.3 of the middle, on the second at +-0.5.
  const auto contacts_on = [&](const Tensor& which) {
    const Tensor side = 0.3 + 0.2 * which.to(torch::kFloat32).unsqueeze(1);
    return torch::cat({side, torch::zeros_like(side), torch::zeros_like(side), -side, torch::zeros_like(side),
                       torch::zeros_like(side)},
                      1);
  };
  torch::optim::Adam optimiser(network->parameters(), 3e-3);
  for (int step = 0; step < 600; ++step) {
    const Tensor which = torch::randint(2, {16}), chair = chairs.index_select(0, which), truth = contacts_on(which);
    const nn::LatentDistribution q = network->encode(truth, chair);
    const Tensor loss = (network->decode(q.sample(torch::randn_like(q.mean)), chair) - truth).square().sum(1).mean() +
                        0.1 * q.divergence();
    optimiser.zero_grad();
    loss.backward();
    optimiser.step();
  }
  const torch::NoGradGuard no_gradients;
  const Tensor which = torch::tensor({0, 1, 0, 1}, torch::kInt64);
  const Tensor drawn = network->decode(torch::randn({4, c.contact_z}), chairs.index_select(0, which));
  EXPECT_LT(largest_difference(drawn, contacts_on(which)), 0.05);
}

}  // namespace
}  // namespace inhabit::interact
