// Protects the rows that every method is measured in: interpolation around obstacles goes around and is left alone
// where nothing stands, and post-processing keeps keys, clears feet and is the same for all.
#include "inhabit/inbetween/methods.h"

#include <gtest/gtest.h>

#include "inbetween/table_detour.h"
#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/evaluate.h"
#include "inhabit/metrics/foot_skating.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

Clip run(const Method& method, const Clip& given, const Scene& scene, const std::vector<int64_t>& keys) {
  const Window window{"window", given, given, std::make_shared<const Scene>(scene)};
  return method.run({window, keys}, 1);
}

TEST(InterpolationMethods, GoAroundWhatStandsInTheWay) {
  const Detour detour = table_detour(121, 30);
  const std::vector<Method> methods = interpolation_methods();
  ASSERT_EQ(methods.size(), 4U);
  for (const size_t m : {0, 1}) {
    const std::vector<int64_t> keys = {0, 120};
    const Clip straight = run(methods[m], detour.ends, detour.room, keys),
               around = run(methods[m + 2], detour.ends, detour.room, keys);
    EXPECT_TRUE(crosses_table(straight)) << methods[m].name;
    EXPECT_FALSE(crosses_table(around)) << methods[m + 2].name;
    for (const int64_t key : keys)
      EXPECT_TRUE(around.joints[key].allclose(detour.ends.joints[key], 0, 1e-4)) << methods[m + 2].name;
    EXPECT_LT(around.joints.diff(1, 0).norm(2, {2}).max().item<double>(), 0.12) << "no jump";
    const Clip empty = run(methods[m + 2], detour.ends, floor_scene(), keys);
    EXPECT_TRUE(empty.joints.equal(straight.joints)) << "nothing stands there";
  }
}

TEST(WithRefine, KeepsKeysAndClearsFeet) {
  const Detour detour = table_detour(121, 30);
  const std::vector<int64_t> keys = {0, 120};
  const Method plain = interpolation_methods()[2], refined = with_refine(plain);
  EXPECT_EQ(refined.name, "slerp + detour + refine");
  EXPECT_FALSE(refined.random);
  const Clip before = run(plain, detour.ends, detour.room, keys), after = run(refined, detour.ends, detour.room, keys);
  EXPECT_EQ(after.frames(), before.frames());
  for (const int64_t key : keys)
    EXPECT_LT((after.joints[key] - detour.ends.joints[key]).norm(2, {1}).mean().item<double>(), 2e-3);
  EXPECT_LT(foot_skating(after).fraction(), 0.5 * foot_skating(before).fraction());
}

TEST(RowName, SaysWhatAConfigurationLacks) {
  Config c;
  EXPECT_EQ(row_name(c), "ours");
  c.global_scene = false;
  EXPECT_EQ(row_name(c), "w/o global feature");
  c.local_scene = c.body_shape = false;
  c.t_star = 20;
  EXPECT_EQ(row_name(c), "w/o scene, body shape (T* = 20)");
}

}  // namespace
}  // namespace inhabit::inbetween
