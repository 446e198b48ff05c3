// Protects sampling: keys hold exactly, whatever the sampler; the three samplers agree with closed forms where the
// ideal denoiser is known (data that are normally distributed); the same seed gives the same numbers.
#include "inhabit/inbetween/sampler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include <cmath>
#include <set>

#include "inhabit/math/dct.h"
#include "largest.h"
#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

using ::testing::HasSubstr;
using torch::Tensor;

constexpr Sampler kSamplers[] = {Sampler::ddpm, Sampler::ddim, Sampler::dpm_solver};

/// Clips of 2 features and 5 frames, normally distributed.
struct Normal {
  static constexpr int64_t kFeatures = 2, kFrames = 5, kAll = kFeatures * kFrames;
  Tensor mean, covariance;  // (10), (10, 10) double

  Normal() {
    torch::manual_seed(11);
    mean = torch::randn({kAll}, torch::kFloat64);
    const Tensor root = torch::randn({kAll, kAll}, torch::kFloat64) / std::sqrt(kAll);
    covariance = torch::matmul(root, root.t()) + 0.05 * torch::eye(kAll, torch::kFloat64);
  }

  /// E[x_0 | x_t], the best that a denoiser can do, with everything in double.
  Tensor denoised(const Tensor& x, double a) const {
    const Tensor all = a * covariance + (1 - a) * torch::eye(kAll, torch::kFloat64);
    const Tensor gain = std::sqrt(a) * torch::matmul(covariance, torch::inverse(all));
    const Tensor off = x.flatten(1).to(torch::kFloat64) - std::sqrt(a) * mean;
    return (mean + torch::matmul(off, gain.t())).to(x.scalar_type()).view_as(x);
  }
  /// Where the deterministic flow takes x_T: along each main axis it keeps its number of deviations.
  Tensor flowed(const Tensor& x, double a) const {
    const auto [lengths, axes] = torch::linalg_eigh(covariance, "L");
    const Tensor off = torch::matmul(x.flatten(1).to(torch::kFloat64) - std::sqrt(a) * mean, axes);
    return (mean + torch::matmul(off * (lengths / (a * lengths + 1 - a)).sqrt(), axes.t())).view_as(x);
  }
};

KeyConstraints nothing(int64_t batch, int64_t features, int64_t frames) {
  return {torch::zeros({batch, features, frames}), torch::zeros({batch, features, frames}), 0};
}

NoiseSource noise_of(int64_t batch, int64_t features, int64_t frames) {
  torch::manual_seed(21);
  return [=](int64_t) { return torch::randn({batch, features, frames}); };
}

TEST(Sampler, StepsAreSpreadFromTheNoisiest) {
  const std::vector<int64_t> all = sampling_steps(1000, 1000, 20);
  for (int64_t i = 0; i < 1000; ++i) EXPECT_EQ(all[static_cast<size_t>(i)], 999 - i);
  for (const int64_t count : {1, 2, 7, 20, 333, 999}) {
    const std::vector<int64_t> steps = sampling_steps(1000, count, 0);
    ASSERT_EQ(static_cast<int64_t>(steps.size()), count);
    EXPECT_EQ(steps.front(), 999);
    EXPECT_GE(steps.back(), 0);
    for (size_t i = 1; i < steps.size(); ++i) {
      EXPECT_LT(steps[i], steps[i - 1]);
      EXPECT_LE(steps[i - 1] - steps[i], 1000 / count + 1);
    }
  }
  EXPECT_EQ(sampling_steps(1000, 20, 20).back(), 19) << "keys are denoised too";
  EXPECT_EQ(sampling_steps(1000, 500, 20).back(), 1);
  for (const int64_t count : {-3, 0, 51})
    EXPECT_THAT(refusal_of([&] { sampling_steps(50, count, 0); }), HasSubstr("is not within 1 and 50"));
}

TEST(Sampler, CleanKeysAreSeenAndHoldExactly) {
  const DiffusionSchedule schedule = cosine_schedule(50);
  for (const Sampler sampler : kSamplers) {
    for (const int64_t count : {1, 8, 50}) {
      torch::manual_seed(2);
      // Partial keys too: single features of a frame.
      KeyConstraints given{torch::randn({2, 4, 9}), torch::rand({2, 4, 9}) < 0.3, 0};
      given.mask = given.mask.to(torch::kFloat32);
      int64_t calls = 0;
      const Tensor got = sample(
          schedule, sampler, count,
          [&](const Tensor& x, int64_t) {
            ++calls;
            EXPECT_EQ(largest((x - given.values) * given.mask), 0);
            EXPECT_GT(largest((x - given.values) * (1 - given.mask)), 0);
            return 0.3 * x + 0.1;
          },
          given, noise_of(2, 4, 9));
      EXPECT_EQ(calls, count);
      EXPECT_EQ(largest((got - given.values) * given.mask), 0);
      EXPECT_TRUE(got.isfinite().all().item<bool>());
    }
  }
}

TEST(Sampler, NoisyKeysHoldFromTStarOnOnlyAndEndsAlways) {
  const DiffusionSchedule schedule = cosine_schedule(50);
  for (const Sampler sampler : kSamplers) {
    KeyConstraints given{torch::full({1, 3, 9}, 7.F), torch::zeros({1, 3, 9}), 12};
    for (const int64_t key : {0, 4, 8}) given.mask.select(2, key).fill_(1);
    std::set<bool> seen_inside;
    const Tensor got = sample(
        schedule, sampler, 10,
        [&](const Tensor& x, int64_t t) {
          EXPECT_EQ(largest(x.select(2, 0) - 7), 0);
          EXPECT_EQ(largest(x.select(2, 8) - 7), 0);
          EXPECT_EQ(largest(x.select(2, 4) - 7) == 0, t >= 12) << t;
          seen_inside.insert(t >= 12);
          return torch::full_like(x, 0.5);
        },
        given, noise_of(1, 3, 9));
    EXPECT_EQ(seen_inside.size(), 2U);
    EXPECT_EQ(largest(got.select(2, 0) - 7), 0);
    EXPECT_EQ(largest(got.select(2, 8) - 7), 0);
    EXPECT_LT(largest(got.slice(2, 1, 8) - 0.5), 1e-6) << "what the denoiser made of the key, not the key";
  }
}

TEST(Sampler, ImputationGoesByEachSamplesOwnStep) {
  const Tensor x = torch::zeros({2, 1, 4});
  const KeyConstraints given{torch::ones({2, 1, 4}), torch::ones({2, 1, 4}), 20};
  const Tensor got = impute(x, given, torch::tensor({19, 20}));
  EXPECT_TRUE(torch::equal(got[0], torch::tensor({{1.F, 0.F, 0.F, 1.F}})));
  EXPECT_TRUE(torch::equal(got[1], torch::ones({1, 4})));
  // Where it is said what holds at every step, the ends hold no more than others do.
  KeyConstraints named = given;
  named.always = torch::tensor({0.F, 1.F, 0.F, 0.F}).expand({2, 1, 4});
  EXPECT_TRUE(torch::equal(impute(x, named, torch::tensor({19, 20}))[0], torch::tensor({{0.F, 1.F, 0.F, 0.F}})));
}

TEST(Sampler, DeterministicSamplersFollowTheFlowOfNormalData) {
  const Normal data;
  const DiffusionSchedule schedule = cosine_schedule(1000);
  const int64_t batch = 64;
  const KeyConstraints none = nothing(batch, data.kFeatures, data.kFrames);
  torch::manual_seed(4);
  const Tensor start = torch::randn({batch, data.kFeatures, data.kFrames});
  const Tensor expected = data.flowed(start, schedule.alphas_cumprod.back());
  const auto error = [&](Sampler sampler, int64_t count) {
    const Tensor got = sample(
        schedule, sampler, count,
        [&](const Tensor& x, int64_t t) { return data.denoised(x, schedule.alphas_cumprod[static_cast<size_t>(t)]); },
        none, [&](int64_t) { return start; });
    return (got - expected).square().mean().sqrt().item<double>();
  };
  const double ddim_1000 = error(Sampler::ddim, 1000), ddim_20 = error(Sampler::ddim, 20),
               ddim_40 = error(Sampler::ddim, 40), solver_20 = error(Sampler::dpm_solver, 20),
               solver_40 = error(Sampler::dpm_solver, 40);
  std::cout << "  DDIM 1000, 40, 20: " << ddim_1000 << " " << ddim_40 << " " << ddim_20
            << "; DPM-Solver++ 40, 20: " << solver_40 << " " << solver_20 << "\n";
  EXPECT_LT(ddim_1000, 0.01);
  EXPECT_LT(solver_40, 0.03);
  EXPECT_LT(ddim_1000, ddim_40);
  EXPECT_LT(ddim_40, 0.7 * ddim_20);    // first order
  EXPECT_LT(solver_20, 0.7 * ddim_20);  // and the solver of second order ahead of it
  EXPECT_LT(solver_40, 0.6 * solver_20);
}

TEST(Sampler, AllSamplersDrawNormalDataAsTheyAreDistributed) {
  const Normal data;
  const DiffusionSchedule schedule = cosine_schedule(1000);
  const int64_t batch = 8192;
  const KeyConstraints none = nothing(batch, data.kFeatures, data.kFrames);
  for (const auto& [sampler, count] :
       {std::pair(Sampler::ddpm, 1000), {Sampler::ddim, 200}, {Sampler::dpm_solver, 40}}) {
    SCOPED_TRACE(static_cast<int>(sampler));
    const Tensor got = sample(
                           schedule, sampler, count,
                           [&](const Tensor& x, int64_t t) {
                             return data.denoised(x, schedule.alphas_cumprod[static_cast<size_t>(t)]);
                           },
                           none, noise_of(batch, data.kFeatures, data.kFrames))
                           .flatten(1)
                           .to(torch::kFloat64);
    const Tensor off = got - got.mean(0);
    const Tensor covariance = torch::matmul(off.t(), off) / (batch - 1);
    // Five standard errors of the mean; the covariance's is about its largest entry over the root of the batch.
    EXPECT_LT(largest((got.mean(0) - data.mean) / data.covariance.diagonal().sqrt()), 5 / std::sqrt(batch) + 0.005);
    EXPECT_LT(largest(covariance - data.covariance), 0.08 * largest(data.covariance));
  }
}

TEST(Sampler, AllSamplersDrawNormalDataGivenTheirKeys) {
  const Normal data;
  const DiffusionSchedule schedule = cosine_schedule(1000);
  const int64_t batch = 8192, frames = data.kFrames;
  // The first and the last frame are given; what is between them is distributed as Bayes' rule says.
  KeyConstraints given = nothing(batch, data.kFeatures, frames);
  for (const int64_t end : {int64_t{0}, frames - 1}) {
    given.mask.select(2, end).fill_(1);
    given.values.select(2, end).fill_(0.4F);
  }
  const Tensor key = given.mask[0].flatten() > 0;
  const Tensor k = key.nonzero().squeeze(1), o = key.logical_not().nonzero().squeeze(1);
  const auto block = [&](const Tensor& a, const Tensor& b) {
    return data.covariance.index_select(0, a).index_select(1, b);
  };
  const Tensor gain = torch::matmul(block(o, k), torch::inverse(block(k, k)));
  const Tensor mean = data.mean.index_select(0, o) + torch::matmul(gain, 0.4 - data.mean.index_select(0, k));
  const Tensor covariance = block(o, o) - torch::matmul(gain, block(k, o));
  const auto denoised = [&](const Tensor& x, int64_t t) {
    const double a = schedule.alphas_cumprod[static_cast<size_t>(t)];
    const Tensor all = a * covariance + (1 - a) * torch::eye(o.size(0), torch::kFloat64);
    const Tensor off = x.flatten(1).index_select(1, o).to(torch::kFloat64) - std::sqrt(a) * mean;
    const Tensor inside = mean + std::sqrt(a) * torch::matmul(off, torch::matmul(covariance, torch::inverse(all)).t());
    return torch::zeros_like(x).flatten(1).index_copy(1, o, inside.to(torch::kFloat32)).view_as(x);
  };
  for (const auto& [sampler, count] :
       {std::pair(Sampler::ddpm, 1000), {Sampler::ddim, 200}, {Sampler::dpm_solver, 40}}) {
    SCOPED_TRACE(static_cast<int>(sampler));
    const Tensor got =
        sample(schedule, sampler, count, denoised, given, noise_of(batch, data.kFeatures, frames)).flatten(1);
    EXPECT_EQ(largest(got.index_select(1, k) - 0.4F), 0);
    const Tensor inside = got.index_select(1, o).to(torch::kFloat64);
    const Tensor off = inside - inside.mean(0);
    EXPECT_LT(largest((inside.mean(0) - mean) / covariance.diagonal().sqrt()), 5 / std::sqrt(batch) + 0.01);
    EXPECT_LT(largest(torch::matmul(off.t(), off) / (batch - 1) - covariance), 0.08 * largest(covariance));
  }
}

TEST(Sampler, TheSeedDecides) {
  const DiffusionSchedule schedule = cosine_schedule(50);
  const auto drawn = [&](Sampler sampler, int64_t batch, uint64_t seed) {
    return sample(
        schedule, sampler, 10, [](const Tensor& x, int64_t) { return 0.5 * x; }, nothing(batch, 3, 7),
        seeded_noise(batch, 3, 7, seed));
  };
  for (const Sampler sampler : kSamplers) {
    const Tensor one = drawn(sampler, 2, 5);
    EXPECT_TRUE(torch::equal(one, drawn(sampler, 2, 5)));
    EXPECT_FALSE(torch::equal(one, drawn(sampler, 2, 6)));
    EXPECT_FALSE(torch::equal(one[0], one[1]));
    EXPECT_TRUE(torch::equal(one, drawn(sampler, 4, 5).slice(0, 0, 2))) << "whatever is drawn beside it";
  }
  const Tensor z = seeded_noise(1, 100, 100, 1)(3);
  EXPECT_NEAR(z.mean().item<double>(), 0, 0.05);
  EXPECT_NEAR(z.std().item<double>(), 1, 0.05);
}

TEST(Sampler, TheTemperatureIsOfTheSlowPartAlone) {
  const NoiseSource noise = seeded_noise(2, 3, 60, 1);
  EXPECT_TRUE(torch::equal(with_temperature(noise, 1)(0), noise(0)));
  const Tensor basis = dct_matrix(60, 60), whole = noise(0).matmul(basis.t());
  for (const double temperature : {0.0, 0.5, 2.0}) {
    const Tensor got = with_temperature(noise, temperature)(0).matmul(basis.t());
    EXPECT_TRUE(torch::allclose(got.narrow(2, 0, 4), temperature * whole.narrow(2, 0, 4), 1e-4, 1e-5));
    EXPECT_TRUE(torch::allclose(got.narrow(2, 4, 56), whole.narrow(2, 4, 56), 1e-4, 1e-5));
  }
  EXPECT_LT(with_temperature(seeded_noise(1, 2, 3, 1), 0)(0).abs().max().item<double>(), 1e-6) << "nothing but slow";
}

TEST(Sampler, TellsItsProgress) {
  std::vector<int64_t> told;
  sample(
      cosine_schedule(50), Sampler::ddim, 4, [](const Tensor& x, int64_t) { return x; }, nothing(1, 2, 3),
      seeded_noise(1, 2, 3, 1), [&](int64_t done) { told.push_back(done); });
  EXPECT_EQ(told, (std::vector<int64_t>{1, 2, 3, 4}));
}

TEST(InterpolateKeys, RunsStraightBetweenKeysAndIsConstantOutside) {
  KeyConstraints given;
  given.values =
      torch::tensor({9.F, 1.F, 9.F, 9.F, 7.F, 9.F, 5.F, 9.F, 9.F, 9.F, 9.F, 9.F, 3.F, 3.F, 3.F, 3.F, 3.F, 3.F})
          .view({1, 3, 6});
  given.mask = torch::zeros({1, 3, 6});
  given.mask[0][0][1] = given.mask[0][0][4] = given.mask[0][1][0] = 1;
  const Tensor expected =
      torch::tensor({1.F, 1.F, 3.F, 5.F, 7.F, 7.F, 5.F, 5.F, 5.F, 5.F, 5.F, 5.F, 0.F, 0.F, 0.F, 0.F, 0.F, 0.F})
          .view({1, 3, 6});
  EXPECT_LT(largest_difference(interpolate_keys(given), expected), 1e-6);
}

TEST(Sampler, ImposesWhatHoldsAndNothingElseWhereAsked) {
  torch::manual_seed(5);
  const Tensor predicted = torch::randn({2, 3, 20});
  KeyConstraints given{torch::randn({2, 3, 20}), torch::zeros({2, 3, 20})};
  given.mask.select(2, 6).fill_(1);
  const auto sampled = [&] {
    return sample(
        cosine_schedule(50), Sampler::ddim, 1, [&](const Tensor&, int64_t) { return predicted; }, given,
        seeded_noise(2, 3, 20, 1));
  };
  const Tensor imposed = sampled();
  EXPECT_TRUE(torch::equal(imposed.select(2, 6), given.values.select(2, 6)));
  EXPECT_LT(largest((imposed - predicted).slice(2, 7)), 1e-5);
  given.imposed = false;
  EXPECT_LT(largest(sampled() - predicted), 1e-5) << "the residual can be seen";
  given.imposed = true;
  given.t_star = 20;  // the key in the middle is cleaned, too: only the ends hold
  given.mask.fill_(1);
  const Tensor cleaned = sampled();
  EXPECT_LT(largest((cleaned - predicted).slice(2, 1, 19)), 1e-5);
  EXPECT_TRUE(torch::equal(cleaned.select(2, 19), given.values.select(2, 19)));
}

}  // namespace
}  // namespace inhabit::inbetween
