// Protects the rows that every method is measured in: interpolation around obstacles goes around and is left alone
// where nothing stands, post-processing keeps keys, clears feet and is the same for all, and models have the rows that
// are asked for.
#include "inhabit/inbetween/methods.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inbetween/small_network.h"
#include "inbetween/table_detour.h"
#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/evaluate.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/metrics/foot_skating.h"
#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
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

/// Sizes that a test can wait for, weights of no training.
Networks small_model(const std::string& named_preset, int t_star = 0) {
  Networks out;
  out.config = preset(named_preset);
  out.config.width = 32;
  out.config.multipliers = {1, 1};
  out.config.t_star = t_star;
  out.network = untrained(out.config);
  return out;
}

/// Names of the rows behind the interpolations'.
std::vector<std::string> names_of_model_rows(MeasuredModels models, bool noisy = false) {
  models.refine = false;
  std::vector<std::string> out;
  for (const Method& row : evaluation_rows(models, noisy)) out.push_back(row.name);
  const size_t others = models.options.key_groups.defined() ? 0 : interpolation_rows(noisy, false).size();
  out.erase(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(others));
  return out;
}

TEST(EvaluationRows, AreTheInterpolationsAndEachModelWithEachOfItsSettings) {
  const Networks model = small_model("compact");  // which starts from an interpolation
  const std::vector<Method> rows = evaluation_rows({.networks = {{"m", model}}}, /*noisy=*/true);
  ASSERT_EQ(rows.size(), 10U + 3U);
  EXPECT_EQ(rows[1].name, "linear + slerp + refine");
  EXPECT_EQ(rows[9].name, "smoother + refine");
  EXPECT_THAT(names_of_model_rows({.networks = {{"m", model}}}, /*noisy=*/true),
              ElementsAre("ours, input", "ours, raw", "ours"));
  // With another guidance what the network starts from is the same; with other detours it is not.
  EXPECT_THAT(
      names_of_model_rows({.networks = {{"m", model}, {"n", model}},
                           .others = {{"blind", {"inference.guidance=0"}},
                                      {"straight", {"detours=straight", "inference.guidance=0"}}}}),
      ElementsAre("ours, input", "ours, raw", "ours", "ours, blind, raw", "ours, blind", "ours, straight, input",
                  "ours, straight, raw", "ours, straight", "ours, input", "ours, raw", "ours", "ours, blind, raw",
                  "ours, blind", "ours, straight, input", "ours, straight, raw", "ours, straight"));
  MeasuredModels partial = {.networks = {{"m", model}}};
  partial.options.key_groups = key_groups("pelvis");
  EXPECT_EQ(evaluation_rows(partial).size(), 3U) << "interpolations know whole poses only";
}

TEST(EvaluationRows, HaveEachTStarOfANoiseAwareModel) {
  MeasuredModels models = {.networks = {{"m", small_model("features", 20)}}};
  EXPECT_THAT(names_of_model_rows(models), Contains("ours (T* = 20)"));
  models.t_star = {5, 10};
  const std::vector<std::string> names = names_of_model_rows(models);
  EXPECT_THAT(names, AllOf(Contains("ours (T* = 5)"), Contains("ours (T* = 10)"), Not(Contains("ours (T* = 20)"))));
  EXPECT_EQ(models.networks[0].second.config.t_star, 20);
  models.networks.emplace_back("other.safetensors", small_model("features"));
  EXPECT_THAT(refusal_of([&] { evaluation_rows(models); }),
              HasSubstr("other.safetensors: was not trained on noisy key frames"));
}

TEST(EvaluationRows, RefuseSettingsThatAreNotOfHowAModelIsUsed) {
  MeasuredModels models = {.networks = {{"m", small_model("compact")}}, .others = {{"a", {"frames=3"}}}};
  EXPECT_THAT(refusal_of([&] { evaluation_rows(models); }), HasSubstr("--set frames=3: is how the networks were made"));
  models.others = {{"a", {"detours=left"}}};
  EXPECT_THAT(refusal_of([&] { evaluation_rows(models); }), HasSubstr("none of learned, searched and straight"));
  for (const char* temperature : {"temperature=cold", "temperature=-1", "temperature=nan", "temperature="}) {
    models.others = {{"a", {temperature}}};
    EXPECT_THAT(refusal_of([&] { evaluation_rows(models); }), HasSubstr("is no number from 0 to 2"));
  }
}

}  // namespace
}  // namespace inhabit::inbetween
