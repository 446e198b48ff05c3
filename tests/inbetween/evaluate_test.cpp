// Protects the evaluation of in-betweening: a method that returns the truth scores as the truth, each planted fault
// raises the number that is to tell it, and runs, seeds, noise and tables are what they say.
#include "inhabit/inbetween/evaluate.h"

#include <gmock/gmock.h>

#include <set>

#include "inbetween/windows_of.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/inbetween/window_scores.h"
#include "inhabit/math/rotation.h"
#include "inhabit/scene/shapes.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::inbetween {
namespace {

using testing::HasSubstr;
using torch::Tensor;

using Fill = std::function<Clip(const FillTask&, uint64_t)>;

/// A method that gives the truth with its root moved by what `shift` (T, 3) says.
Method shifted(const std::string& name, const Tensor& shift) {
  return {name,
          [shift](const FillTask& task, uint64_t) {
            Clip out = task.window.truth;
            out.trans = out.trans + shift;
            out.joints = out.joints + shift.unsqueeze(1);
            return out;
          },
          false};
}

const Scores& row(const Table& table, const std::string& method) {
  for (const Scores& scores : table.rows)
    if (scores.method == method) return scores;
  throw std::runtime_error("no row " + method);
}

TEST(Estimate, IsMeanAndStudentsInterval) {
  const Estimate three = estimate({1, 2, 3});
  EXPECT_DOUBLE_EQ(three.mean, 2);
  EXPECT_NEAR(three.interval, 4.303 / std::sqrt(3.0), 1e-9);
  EXPECT_DOUBLE_EQ(estimate({7}).mean, 7);
  EXPECT_DOUBLE_EQ(estimate({7}).interval, 0);
  EXPECT_TRUE(std::isnan(estimate({}).mean));
  std::vector<double> many;  // 122 values of deviation 1.004..: t of 121 degrees of freedom is 1.980
  for (int i = 0; i < 61; ++i) many.insert(many.end(), {-1, 1});
  EXPECT_NEAR(estimate(many).interval, 1.980 * std::sqrt(122.0 / 121) / std::sqrt(122.0), 2e-4);
}

TEST(NoisyKeys, HasTheLevelInCentimetresAndDegreesAndCleanEnds) {
  const Clip clip = walker(1500, 0.5, 0.4, 0.5);
  const Clip noisy = noisy_keys(clip, 2, 11);
  for (const int64_t end : {int64_t{0}, int64_t{1499}}) {
    EXPECT_TRUE(noisy.joints[end].allclose(clip.joints[end], 0, 1e-5));
    EXPECT_TRUE(noisy.rotations[end].allclose(clip.rotations[end], 0, 1e-4));
  }
  const Tensor moved = (noisy.trans - clip.trans).slice(0, 1, 1499);
  EXPECT_NEAR(moved.std().item<double>(), 0.02, 0.001);
  EXPECT_NEAR(moved.mean().item<double>(), 0, 0.0015);
  const Tensor rotation = matrix_to_axis_angle(torch::matmul(axis_angle_to_matrix(clip.rotations).transpose(-1, -2),
                                                             axis_angle_to_matrix(noisy.rotations)))
                              .slice(0, 1, 1499);
  EXPECT_NEAR(rotation.std().item<double>(), 2 * M_PI / 180, 0.001);
  EXPECT_TRUE(noisy.joints.allclose(joint_positions(noisy.skeleton, noisy.rotations, noisy.trans), 1e-4, 1e-4));
  EXPECT_TRUE(noisy_keys(clip, 2, 11).joints.equal(noisy.joints));
  EXPECT_FALSE(noisy_keys(clip, 2, 12).joints.equal(noisy.joints));
  EXPECT_TRUE(noisy_keys(clip, 0, 11).joints.equal(clip.joints));
  for (const double level : {-1.0, 91.0, std::nan("")})
    EXPECT_THAT(refusal_of([&] { noisy_keys(clip, level, 1); }), HasSubstr("noise level"));
}

TEST(EvaluateInbetween, TruthScoresAsTruthAndEachFaultInItsOwnNumber) {
  std::vector<Window> windows = walking_windows(4);
  for (Window& window : windows) window.truth.trans.select(1, 1).add_(0.5);  // off the floor: nothing skates
  torch::manual_seed(1);
  MotionAutoencoder features;  // untrained convolutions tell motions apart as well, at another scale
  features->deviation.fill_(1e-3);
  const Tensor t = torch::arange(121).to(torch::kFloat32);
  Tensor between = torch::zeros({121, 3}), shake = torch::zeros({121, 3}), slide = torch::zeros({121, 3});
  between.select(1, 0).slice(0, 1, 120).fill_(0.05);
  for (const int64_t key : {0, 60, 120}) between[key].zero_();
  shake.select(1, 1).copy_(0.01 * torch::cos(M_PI * t));
  slide.select(1, 1).fill_(-0.5);  // down again, where their feet glide over the floor
  const Table table = evaluate(
      windows,
      {shifted("truth", torch::zeros({121, 3})), shifted("up", torch::tensor({0.F, 0.02F, 0.F}).expand({121, 3})),
       shifted("between", between), shifted("shake", shake), shifted("slide", slide)},
      features, {});
  EXPECT_EQ(table.windows, 4);
  const Scores &real = row(table, "real motion"), &truth = row(table, "truth");
  EXPECT_GT(real.fid.mean, 0) << "the floor: halves of the real motion";
  EXPECT_EQ(table.dimensions, 1);
  EXPECT_NEAR(truth.fid.mean, 0, 1e-6);
  EXPECT_EQ(truth.key_error.mean, 0);
  EXPECT_EQ(truth.error.mean, 0);
  EXPECT_DOUBLE_EQ(truth.jerk.mean, real.jerk.mean);
  EXPECT_DOUBLE_EQ(truth.jerk_ratio.mean, 1);
  EXPECT_GT(real.jerk.mean, 0);
  EXPECT_EQ(truth.frame_ratio.mean, 0);
  EXPECT_NEAR(row(table, "up").key_error.mean, 20, 1e-3);
  EXPECT_NEAR(row(table, "up").error.mean, 20, 1e-3);
  EXPECT_EQ(row(table, "between").key_error.mean, 0);
  EXPECT_NEAR(row(table, "between").error.mean, 50. * 118 / 121, 1e-2);
  EXPECT_GT(row(table, "shake").jerk.mean, 3 * real.jerk.mean);
  EXPECT_GT(row(table, "shake").fid.mean, 1e-3);
  EXPECT_EQ(real.skating.mean, 0);
  EXPECT_GT(row(table, "slide").skating.mean, 0.5);
  EXPECT_EQ(row(table, "slide").keyframes, "every:60");
}

TEST(EvaluateInbetween, CountsWhatRunsIntoTheScene) {
  // A post beside the path of somebody who walks along +Z; half a second of stepping aside runs into it.
  Window window;
  window.name = "path";
  window.truth = walker(121, 1.0);
  MeshBuilder post;
  post.box({0.8, 1, 2}, {0.05, 1, 0.3});
  auto scene = std::make_shared<Scene>();
  scene->meshes.push_back(post.mesh("post_0", {1, 1, 1}));
  window.scene = scene;
  Tensor aside = torch::zeros({121, 3});
  aside.select(1, 0).slice(0, 50, 70).fill_(0.8F);
  const Table table = evaluate({window}, {shifted("straight", torch::zeros({121, 3})), shifted("aside", aside)},
                               MotionAutoencoder{nullptr}, {});
  const Scores &straight = row(table, "straight"), &into = row(table, "aside");
  EXPECT_EQ(straight.frame_ratio.mean, 0);
  EXPECT_GT(into.frame_ratio.mean, 0.1);
  EXPECT_LE(into.frame_ratio.mean, 20. / 121 + 1e-9);
  EXPECT_GT(into.penetration.mean, 20);
  EXPECT_GT(into.vertex_ratio.mean, 0);
  // Frames in which the true motion passes the post close by count by themselves: there are none at 8 cm, as the
  // walker's arms hang down.
  EXPECT_EQ(table.close_frames, 0);
  EXPECT_TRUE(std::isnan(into.close_frame_ratio.mean));
  EXPECT_TRUE(std::isnan(into.fid.mean));  // without an autoencoder

  window.truth = into.method == "aside" ? shifted("", aside).run({window, {}}, 0) : window.truth;
  const Table near_post = evaluate({window}, {shifted("same", torch::zeros({121, 3})), shifted("back", -aside)},
                                   MotionAutoencoder{nullptr}, {});
  EXPECT_EQ(near_post.close_frames, 20);
  const Scores& same = row(near_post, "same");
  EXPECT_NEAR(same.close_frame_ratio.mean * 20, same.frame_ratio.mean * 121, 1e-4);
  EXPECT_NEAR(same.close_vertex_ratio.mean * 20, same.vertex_ratio.mean * 121, 1e-4);
  EXPECT_EQ(same.close_penetration.mean, same.penetration.mean);
  EXPECT_EQ(row(near_post, "back").close_frame_ratio.mean, 0);
}

TEST(EvaluateInbetween, PartsGiveTheTableOfAllInOne) {
  const TempFolder folder;
  std::vector<Window> windows = walking_windows(5);
  for (Window& window : windows) window.scene = std::make_shared<Scene>(floor_scene());
  torch::manual_seed(1);
  MotionAutoencoder features;
  features->deviation.fill_(1e-3);
  const Method drawn = {
      "drawn",
      [](const FillTask& task, uint64_t seed) {
        Clip out = task.window.truth;
        const Tensor shift = torch::zeros({121, 3});
        shift.select(1, 0).copy_(1e-4 * static_cast<double>(seed % 100) * torch::arange(121).to(torch::kFloat32));
        out.trans = out.trans + shift;
        out.joints = out.joints + shift.unsqueeze(1);
        return out;
      },
      true};
  Evaluation options;
  options.seeds = 2;
  const Table whole = evaluate(windows, {drawn}, features, options);
  std::vector<Table> parts;
  for (const int64_t number : {2, 1, 3}) {
    options.parts = MeasuredParts({number, 3}, folder / "table.json", "job");
    int64_t filled = 0;
    options.progress = [&](int64_t done, int64_t of) {
      EXPECT_EQ(done, ++filled);
      EXPECT_EQ(of, number == 3 ? 2 : 4);  // runs of windows 0, 3; 1, 4; 2
    };
    parts.push_back(evaluate(windows, {drawn}, features, options));
    EXPECT_EQ(filled, number == 3 ? 2 : 4);
  }
  EXPECT_TRUE(parts[0].rows.empty() && parts[1].rows.empty()) << "the third is still to come";
  EXPECT_EQ(table_json(parts[2]), table_json(whole));
  options.progress = {};
  options.parts = MeasuredParts({1, 3}, folder / "table.json", "another job");
  EXPECT_THAT(refusal_of([&] { evaluate(windows, {drawn}, features, options); }), HasSubstr("another evaluation"));
}

TEST(EvaluateInbetween, RunsSeedsWhereTheyMatterAndGivesAllMethodsTheSame) {
  const std::vector<Window> windows = walking_windows(2);
  struct Seen {
    std::vector<std::pair<std::vector<int64_t>, Tensor>> given;
    std::set<uint64_t> seeds;
  };
  std::map<std::string, Seen> seen;
  const auto watching = [&](const std::string& name, bool random) {
    return Method{name,
                  [&seen, name](const FillTask& task, uint64_t seed) {
                    const Window& w = task.window;
                    seen[name].given.emplace_back(task.keys, w.conditioning.joints);
                    seen[name].seeds.insert(seed);
                    Clip out = w.truth;
                    out.trans = out.trans + static_cast<float>(seed % 100) * 1e-3F;
                    out.joints = joint_positions(out.skeleton, out.rotations, out.trans);
                    return out;
                  },
                  random};
  };
  Evaluation options;
  options.seeds = 3;
  int64_t last_done = 0, last_of = 0;
  options.progress = [&](int64_t done, int64_t of) {
    EXPECT_EQ(done, ++last_done);
    last_of = of;
  };
  const Table clean =
      evaluate(windows, {watching("drawn", true), watching("fixed", false)}, MotionAutoencoder{nullptr}, options);
  EXPECT_EQ(row(clean, "drawn").runs, 3);
  EXPECT_EQ(row(clean, "fixed").runs, 1);
  EXPECT_EQ(seen["drawn"].seeds.size(), 6U);
  EXPECT_EQ(last_done, 8);
  EXPECT_EQ(last_of, 8);
  EXPECT_GT(row(clean, "drawn").error.seeds, 0);
  EXPECT_EQ(row(clean, "fixed").error.seeds, 0);
  EXPECT_TRUE(seen["drawn"].given[0].second.allclose(windows[0].truth.joints, 0, 1e-5));

  seen.clear();
  options.progress = {};
  options.noise = 1;
  options.keyframes = {"random:0.3"};
  const Table noisy =
      evaluate(windows, {watching("drawn", true), watching("fixed", false)}, MotionAutoencoder{nullptr}, options);
  EXPECT_EQ(row(noisy, "fixed").runs, 3);
  ASSERT_EQ(seen["drawn"].given.size(), 6U);
  ASSERT_EQ(seen["fixed"].given.size(), 6U);
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(seen["drawn"].given[i].first, seen["fixed"].given[i].first);
    EXPECT_TRUE(seen["drawn"].given[i].second.equal(seen["fixed"].given[i].second));
  }
  // The input as it is: off by the noise, and restless.
  const Scores &input = row(noisy, "noisy input"), &calm = row(noisy, "real motion");
  EXPECT_EQ(input.runs, 3);
  EXPECT_GT(input.error.mean, 10);
  EXPECT_GT(input.jerk_ratio.mean, 5);
  EXPECT_EQ(calm.error.mean, 0);
  EXPECT_NE(seen["drawn"].given[0].first, seen["drawn"].given[1].first);
  EXPECT_FALSE(seen["drawn"].given[0].second.equal(seen["drawn"].given[1].second));
  const auto before = seen["drawn"].given;
  seen.clear();
  evaluate(windows, {watching("drawn", true)}, MotionAutoencoder{nullptr}, options);
  for (size_t i = 0; i < 6; ++i) EXPECT_TRUE(seen["drawn"].given[i].second.equal(before[i].second));
}

TEST(EvaluateInbetween, MeasuresJointsOfThePosesNotOfTheRecording) {
  std::vector<Window> windows = walking_windows(1);
  windows[0].truth.joints = windows[0].truth.joints + 0.03;  // that the skeleton only comes near to
  const Table table = evaluate(windows, interpolation_methods(), MotionAutoencoder{nullptr}, {});
  EXPECT_NEAR(row(table, "linear + slerp").key_error.mean, 0, 1e-2);
  EXPECT_NEAR(row(table, "cubic spline").key_error.mean, 0, 1e-2);
  EXPECT_GT(row(table, "linear + slerp").error.mean, 5);
}

TEST(EvaluateInbetween, RefusesWhatCannotBeMeasured) {
  const std::vector<Window> windows = walking_windows(1);
  const auto refused = [&](const std::vector<Window>& over, const Fill& fill) {
    return refusal_of([&] { evaluate(over, {{"method", fill, true}}, MotionAutoencoder{nullptr}, {}); });
  };
  const auto truth = [](const FillTask& task, uint64_t) { return task.window.truth; };
  EXPECT_THAT(refused({}, truth), HasSubstr("no window"));
  EXPECT_THAT(refused(windows, [](const FillTask& task, uint64_t) { return slice(task.window.truth, 0, 60); }),
              AllOf(HasSubstr("method on walk 0"), HasSubstr("number of frames")));
  EXPECT_THAT(refused(windows,
                      [](const FillTask& task, uint64_t) {
                        Clip out = task.window.truth;
                        out.joints = out.joints * NAN;
                        return out;
                      }),
              HasSubstr("method on walk 0"));
  std::vector<Window> positions = windows;
  positions[0].truth.rotations = torch::Tensor();
  EXPECT_THAT(refused(positions, truth), HasSubstr("no rotations"));
  Evaluation none;
  none.seeds = 0;
  EXPECT_THAT(refusal_of([&] { evaluate(windows, {}, MotionAutoencoder{nullptr}, none); }), HasSubstr("seeds"));
  none.seeds = 1;
  none.keyframes = {};
  EXPECT_THAT(refusal_of([&] { evaluate(windows, {}, MotionAutoencoder{nullptr}, none); }),
              HasSubstr("choice of key frames"));
}

TEST(EvaluateInbetween, TakesDifferencesWindowByWindow) {
  // Windows whose error is 10, 20, ... 80 mm, and a method that is 1 mm better in each.
  std::vector<Window> windows = walking_windows(8);
  const auto off = [&](const std::string& name, double less) {
    return Method{name,
                  [less](const FillTask& task, uint64_t) {
                    Clip out = task.window.truth;
                    const double n = 1 + std::stod(task.window.name.substr(5));
                    out.joints = out.joints + torch::tensor({0.F, 0.F, static_cast<float>(0.01 * n - less)});
                    return out;
                  },
                  false};
  };
  Evaluation options;
  options.against = "worse";
  const Table table = evaluate(windows, {off("better", 0.001), off("worse", 0)}, MotionAutoencoder{nullptr}, options);
  const Scores &better = row(table, "better"), &worse = row(table, "worse");
  EXPECT_NEAR(worse.error.mean, 45, 1e-3);
  // The deviation of 8 draws of 10 ... 80: 22.9 / sqrt(8) = 8.1.
  EXPECT_NEAR(worse.error.interval, 1.96 * 8.1, 2);
  EXPECT_NEAR(better.error.difference, -1, 1e-3);
  EXPECT_LT(better.error.difference_interval, 0.01);
  EXPECT_EQ(worse.error.difference, 0);
  EXPECT_THAT(table_text(table, Layout::methods, true), HasSubstr("differences from worse"));
  options.against = "nobody";
  EXPECT_THAT(refusal_of([&] { evaluate(windows, {off("better", 0)}, MotionAutoencoder{nullptr}, options); }),
              AllOf(HasSubstr("nobody"), HasSubstr("no row")));
}

TEST(EvaluateInbetween, TheFloorOfFidFallsWithTheWindows) {
  torch::manual_seed(1);
  MotionAutoencoder features;
  features->deviation.fill_(1e-3);
  const auto fid_of_real = [&](int64_t count) {
    Evaluation options;
    return evaluate(walking_windows(count, 3), {}, features, options);
  };
  const Table few = fid_of_real(16), many = fid_of_real(60);
  EXPECT_EQ(few.dimensions, 1);
  EXPECT_EQ(many.dimensions, 6);
  EXPECT_GT(few.rows[0].fid.mean / few.dimensions, many.rows[0].fid.mean / many.dimensions);
}

TEST(EvaluateInbetween, OfNoisyRecordingsTakesNoTruth) {
  Evaluation options;
  options.truth = false;
  torch::manual_seed(1);
  const Table table = evaluate(walking_windows(3), interpolation_methods(), MotionAutoencoder(), options);
  EXPECT_EQ(table.rows[0].method, "recording");
  for (const Scores& scores : table.rows) {
    EXPECT_TRUE(std::isnan(scores.error.mean)) << scores.method;
    EXPECT_TRUE(std::isnan(scores.fid.mean)) << scores.method;
    EXPECT_TRUE(std::isfinite(scores.acceleration.mean)) << scores.method;
    EXPECT_TRUE(std::isfinite(scores.skating.mean)) << scores.method;
  }
  EXPECT_NEAR(row(table, "linear + slerp").key_error.mean, 0, 0.01);
  const std::string text = table_text(table, Layout::recordings);
  EXPECT_THAT(text, AllOf(HasSubstr("Acc. (m/s2)"), HasSubstr("Frames, exact"), HasSubstr("MPJE Key")));
  EXPECT_THAT(text, testing::Not(testing::AnyOf(HasSubstr("MPJE All"), HasSubstr("FID"))));
  EXPECT_EQ(layout_for(table, Layout::methods), Layout::recordings);
  EXPECT_EQ(layout_for(table, Layout::collisions), Layout::collisions);
  Table known = table;
  known.truth = true;
  EXPECT_EQ(layout_for(known, Layout::methods), Layout::methods);
}

TEST(EvaluateInbetween, CountsCollisionsWithoutToleranceToo) {
  Window window;
  window.name = "path";
  window.truth = walker(121, 1.0);
  auto scene = std::make_shared<Scene>();
  MeshBuilder post;
  post.box({0.8, 1, 2}, {0.05, 1, 0.3});
  scene->meshes.push_back(post.mesh("post_0", {1, 1, 1}));
  window.scene = scene;
  Tensor aside = torch::zeros({121, 3});
  aside.select(1, 0).slice(0, 50, 70).fill_(0.8F);
  const Table table = evaluate({window}, {shifted("aside", aside)}, MotionAutoencoder{nullptr}, {});
  const Scores& into = row(table, "aside");
  EXPECT_GE(into.exact_frames.mean, into.frame_ratio.mean);
  EXPECT_GT(into.exact_vertices.mean, into.vertex_ratio.mean);
  EXPECT_GE(into.exact_depth.mean, into.penetration.mean);
  EXPECT_THAT(table_text(table, Layout::collisions), HasSubstr("Vertices, exact"));

  // With a tolerance of one's own: none is exact, and by a metre nothing collides.
  Evaluation own;
  own.tolerance = kNoTolerance;
  const Scores strict = row(evaluate({window}, {shifted("aside", aside)}, MotionAutoencoder{nullptr}, own), "aside");
  EXPECT_EQ(strict.frame_ratio.mean, into.exact_frames.mean);
  EXPECT_EQ(strict.penetration.mean, into.exact_depth.mean);
  own.tolerance = {1, 1};
  const Scores lax = row(evaluate({window}, {shifted("aside", aside)}, MotionAutoencoder{nullptr}, own), "aside");
  EXPECT_EQ(lax.frame_ratio.mean, 0);
  EXPECT_EQ(lax.exact_frames.mean, into.exact_frames.mean);
}

TEST(SittingFrames, AreLabelledOrLow) {
  Clip clip = walker(10, 0);
  EXPECT_EQ(sitting_frames(clip).sum().item<int64_t>(), 0);
  clip.action_names = {"walk", "sit_down", "sit", "stand_up", "lean_back", "turn"};
  clip.action = torch::tensor({0, 1, 2, 3, 4, 5, 0, 0, 0, 0});
  EXPECT_EQ(sitting_frames(clip).sum().item<int64_t>(), 4);
  Clip low = walker(10, 0);
  low.trans.select(1, 1).slice(0, 0, 3).fill_(0.5);
  low.joints = joint_positions(low.skeleton, low.rotations, low.trans);
  EXPECT_EQ(sitting_frames(low).sum().item<int64_t>(), 3);
}

TEST(InbetweenTables, HaveThePapersColumnsAndRows) {
  Evaluation options;
  options.keyframes = {"every:60", "ends"};
  options.seeds = 2;
  options.noise = 0.5;
  const Table table = evaluate(walking_windows(2), interpolation_methods(), MotionAutoencoder{nullptr}, options);
  ASSERT_EQ(table.rows.size(), 10U);  // real, noisy input, four methods with two choices of keys
  const std::string main_table = table_text(table);
  for (const char* title : {"FID", "Foot Skating", "Jerk", "MPJE Key", "MPJE All", "Coll. Frames", "Pene. Max",
                            "linear + slerp, every:60", "cubic spline, ends", "noise of level 0.5", "2 seeds"})
    EXPECT_THAT(main_table, HasSubstr(title));
  EXPECT_THAT(main_table, HasSubstr("+- 95 % by bootstrap over windows"));
  EXPECT_THAT(table_text(table, Layout::seeds), HasSubstr("Student's t"));
  EXPECT_THAT(table_text(table, Layout::methods, true), HasSubstr("differences from linear + slerp"));
  EXPECT_THAT(table_text(table, Layout::close), HasSubstr("closer to the scene than 8 cm"));
  EXPECT_THAT(table_text(table, Layout::settings), testing::Not(HasSubstr("Foot Skating")));
  Table one = table;
  one.rows = {table.rows[0], table.rows[1], table.rows[2], table.rows[6]};
  EXPECT_THAT(table_text(one, Layout::keys), HasSubstr("\nends "));
  const nlohmann::ordered_json json = table_json(table);
  EXPECT_EQ(json["windows"], 2);
  EXPECT_EQ(json["rows"].size(), 10U);
  EXPECT_TRUE(json["rows"][1]["fid"]["mean"].is_null());
  EXPECT_GT(json["rows"][1]["mpje_all_mm"]["interval95"].get<double>(), 0);
  EXPECT_EQ(json["rows"][9]["keyframes"], "ends");
  EXPECT_EQ(json["rows"][2]["mpje_all_mm"]["difference"], 0);
  EXPECT_EQ(json["against"], "linear + slerp");
}

}  // namespace
}  // namespace inhabit::inbetween
