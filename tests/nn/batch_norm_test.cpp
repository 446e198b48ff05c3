// Protects batch normalisation: it is torch's, and shared over ranks it is that of the whole batch, gradients too.
#include "inhabit/nn/batch_norm.h"

#include <gtest/gtest.h>

namespace inhabit::nn {
namespace {

using torch::Tensor;

double apart(const Tensor& a, const Tensor& b) { return (a - b).abs().max().item<double>(); }

/// Every number of a module, by its name.
std::map<std::string, Tensor> numbers_of(const torch::nn::Module& module) {
  std::map<std::string, Tensor> out;
  for (const auto& p : module.named_parameters()) out[p.key()] = p.value().detach().clone();
  for (const auto& b : module.named_buffers()) out[b.key()] = b.value().clone();
  return out;
}

TEST(BatchNorm, IsTorchs) {
  torch::manual_seed(1);
  const Tensor x = torch::randn({4, 3, 2, 5, 2}) * 2 + 1;
  torch::nn::BatchNorm3d theirs(torch::nn::BatchNorm3dOptions(3).eps(1e-4));
  BatchNorm ours(3, 1e-4);
  const auto same = [&] {
    const auto is = numbers_of(*ours), should = numbers_of(*theirs);
    ASSERT_EQ(is.size(), should.size());
    for (const auto& [name, value] : should) EXPECT_LT(apart(is.at(name), value), 1e-6) << name;
    EXPECT_LT(apart(ours->forward(x), theirs->forward(x)), 1e-6);
  };
  same();
  same();
  ours->eval();
  theirs->eval();
  same();
}

/// One rank is the whole batch: the way over ranks must give what the plain one does.
TEST(BatchNorm, SharedOverRanksIsThatOfTheWholeBatch) {
  torch::manual_seed(2);
  const Tensor x = (torch::randn({6, 3, 4}) * 2 + 1).requires_grad_();
  const Tensor wanted = torch::randn({6, 3, 4});
  BatchNorm plain(3), shared(3);
  const auto gradients = [&](BatchNorm& norm) {
    const Tensor y = norm->forward(x);
    auto all = torch::autograd::grad({(y * wanted).sum() + y.pow(3).sum()}, {x, norm->weight, norm->bias});
    all.push_back(y.detach());
    return all;
  };
  const auto should = gradients(plain);
  int asked = 0;
  std::vector<Tensor> is;
  {
    const SharedBatchNorms ranks(1, [&](std::vector<Tensor>&) { ++asked; });
    is = gradients(shared);
  }
  EXPECT_EQ(asked, 4) << "mean and variance, there and back";
  for (size_t i = 0; i < is.size(); ++i) EXPECT_LT(apart(is[i], should[i]), 1e-4) << i;
  EXPECT_LT(apart(shared->running_mean, plain->running_mean), 1e-6);
  EXPECT_LT(apart(shared->running_var, plain->running_var), 1e-6);
  gradients(shared);
  EXPECT_EQ(asked, 4) << "no rank is asked any more";
}

/// Two ranks with half of the batch each, one after the other: the second is told what the first sent.
TEST(BatchNorm, HalvesHaveTheStatisticsOfTheWhole) {
  torch::manual_seed(3);
  const Tensor x = torch::randn({8, 2, 3}) * torch::linspace(0.5, 3, 8).view({8, 1, 1});
  BatchNorm whole(2), half(2);
  const Tensor should = whole->forward(x);
  const Tensor mean = x.mean(torch::IntArrayRef{0, 2}),
               variance = (x - mean.view({1, 2, 1})).square().mean(torch::IntArrayRef{0, 2});
  int asked = 0;
  const SharedBatchNorms ranks(2, [&](std::vector<Tensor>& sent) { sent[0] = asked++ == 0 ? mean : variance; });
  EXPECT_LT(apart(half->forward(x.slice(0, 0, 4)), should.slice(0, 0, 4)), 1e-5);
  EXPECT_LT(apart(half->running_var, whole->running_var), 1e-6);
}

}  // namespace
}  // namespace inhabit::nn
