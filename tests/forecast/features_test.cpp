#include "inhabit/forecast/features.h"

#include <gtest/gtest.h>

#include <cmath>

#include "inhabit/math/dct.h"
#include "largest.h"
#include "small_config.h"

using namespace inhabit;
using namespace inhabit::forecast;
using torch::Tensor;

namespace {

/// Eq. 1-2 with torch operators: (B, F, J, N).
Tensor contact_maps(const Tensor& scene, const Tensor& joints, double sigma) {
  const Tensor distance = (joints.unsqueeze(3) - scene.unsqueeze(1).unsqueeze(1)).norm(2, 4);
  return torch::exp(-0.5 * distance.square() / (sigma * sigma));
}

struct Input {
  Config config = small_forecast_config();
  Tensor scene, motion, past;

  explicit Input(int64_t points, double spread = 1.0) {
    torch::manual_seed(points);
    scene = torch::randn({2, points, 3}) * spread;
    motion = torch::randn({2, 1, config.joints, 3}) * 0.4 +
             torch::cumsum(torch::randn({2, config.frames(), config.joints, 3}) * 0.05, 1);
    past = motion.slice(1, 0, config.past).contiguous();
  }
};

}  // namespace

TEST(ContactFeatures, AreTheDctOfThePaddedMaps) {
  for (const int64_t points : {1, 63, 64, 65, 200}) {
    const Input in(points);
    const Tensor maps = contact_maps(in.scene, in.past, in.config.sigma);
    const Tensor padded =
        torch::cat({maps, maps.slice(1, in.config.past - 1).expand({2, in.config.future, -1, -1})}, 1);
    const Tensor dct = dct_matrix(in.config.frames(), in.config.contact_coefficients);
    const Tensor expected = dct.matmul(padded.flatten(2)).view({2, -1, points});
    EXPECT_LT(largest_difference(contact_features(in.scene, in.past, in.config), expected), 1e-5) << points;
  }
}

TEST(ContactFeatures, FarPointsAreExactlyZero) {
  Input in(50);
  in.scene = in.scene + 30;
  EXPECT_EQ(contact_features(in.scene, in.past, in.config).abs().max().item<float>(), 0);
}

// Parseval: the loss on maps is the loss on coefficients plus what lies beyond them.
TEST(ContactTargets, SquaredErrorOfMapsIsThatOfCoefficientsAndAConstant) {
  const Input in(80);
  const Tensor maps = contact_maps(in.scene, in.motion, in.config.sigma);
  const Tensor target = contact_targets(in.scene, in.motion, in.config);
  const double beyond =
      (maps - contact_maps_from_dct(target, in.config.frames(), in.config.joints)).square().sum().item<double>();
  for (int trial = 0; trial < 3; ++trial) {
    const Tensor guess = target + torch::randn_like(target) * 0.1;
    const double by_maps =
        (maps - contact_maps_from_dct(guess, in.config.frames(), in.config.joints)).square().sum().item<double>();
    const double by_coefficients = (target - guess).square().sum().item<double>();
    EXPECT_NEAR(by_maps, by_coefficients + beyond, 1e-3 * by_maps);
  }
}

TEST(ContactPoints, AreTheLargestOfTheMapsAboveTheThreshold) {
  Input in(90, 0.6);
  const Tensor dct = contact_targets(in.scene, in.motion, in.config);
  const Tensor maps = contact_maps_from_dct(dct, in.config.frames(), in.config.joints);
  const Tensor got = contact_points(in.scene, dct, in.config);
  int touching = 0, apart = 0;
  for (int64_t b = 0; b < 2; ++b) {
    for (int64_t t = 0; t < in.config.future; ++t) {
      for (int64_t j = 0; j < in.config.joints; ++j) {
        const Tensor map = maps[b][in.config.past + t][j];
        const int64_t best = map.argmax().item<int64_t>();
        Tensor expected = torch::zeros({4});
        if (map[best].item<float>() > in.config.inference.contact_threshold) {
          expected.slice(0, 0, 3).copy_(in.scene[b][best]);
          expected[3] = 1;
          ++touching;
        } else {
          ++apart;
        }
        EXPECT_TRUE(torch::equal(got[b][t][j], expected)) << b << " " << t << " " << j;
      }
    }
  }
  EXPECT_GT(touching, 10);
  EXPECT_GT(apart, 10);
}

TEST(ContactPoints, TheFirstOfEqualsWins) {
  Input in(70, 0.1);
  in.scene = in.scene.slice(1, 0, 35).repeat({1, 2, 1});  // every point twice
  const Tensor dct = contact_targets(in.scene, in.motion, in.config);
  const Tensor first_half = contact_points(in.scene.slice(1, 0, 35), dct.slice(2, 0, 35), in.config);
  EXPECT_TRUE(torch::equal(contact_points(in.scene, dct, in.config), first_half));
}

TEST(ContactPoints, OfAKnownMotionAreTheClosestWithinReach) {
  const Input in(90, 0.6);
  const Tensor joints = in.motion.slice(1, in.config.past);
  const Tensor got = true_contact_points(in.scene, joints, in.config);
  const Tensor maps = contact_maps(in.scene, joints, in.config.sigma);
  const Tensor touching = maps.amax(3) > in.config.inference.contact_threshold;
  EXPECT_TRUE(torch::equal(got.select(3, 3) > 0, touching));
  for (int64_t b = 0; b < 2; ++b) {
    for (int64_t t = 0; t < in.config.future; ++t) {
      for (int64_t j = 0; j < in.config.joints; ++j) {
        if (!touching[b][t][j].item<bool>()) {
          EXPECT_EQ(got[b][t][j].abs().max().item<float>(), 0);
          continue;
        }
        const double least = (in.scene[b] - joints[b][t][j]).norm(2, 1).min().item<double>();
        EXPECT_NEAR((got[b][t][j].slice(0, 0, 3) - joints[b][t][j]).norm().item<double>(), least, 1e-5);
      }
    }
  }
}
