// Protects the streams of forecasting and anticipation: they say what the facades say of the same window.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <map>

#include "inhabit/anticipate/anticipate_stream.h"
#include "inhabit/forecast/forecast_stream.h"
#include "poses.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

using anticipate::AnticipateStream;
using anticipate::IntentionAnticipator;
using forecast::ContactForecaster;
using forecast::ForecastStream;
using testing::HasSubstr;

std::shared_ptr<const ContactForecaster> forecaster() {
  static const auto one = std::make_shared<const ContactForecaster>(
      ContactForecaster::load(INHABIT_SOURCE_DIR "/models/forecast-compact.safetensors"));
  return one;
}
std::shared_ptr<const IntentionAnticipator> anticipator() {
  static const auto one = std::make_shared<const IntentionAnticipator>(
      IntentionAnticipator::load(INHABIT_SOURCE_DIR "/models/anticipate-cmu.safetensors"));
  return one;
}

TEST(ForecastStream, SaysWhatTheFacadeSaysOfTheSameWindow) {
  ForecastStream stream(forecaster(), walk_room(), {.poses = {.rate = 2}});
  std::vector<forecast::StreamResult> results;
  for (int64_t t = 0; t < 90; ++t) {
    stream.push("a", 1.7e9 + static_cast<double>(t) / 30, walk().joints[t]);
    if (t % 2 == 1) stream.push("b", static_cast<double>(t) / 30, walk().joints[89 - t]);  // at 15 Hz, backwards
    for (auto& r : stream.take()) results.push_back(std::move(r));
  }
  int compared = 0;
  for (const auto& r : results) {
    ASSERT_EQ(r.error, "");
    ASSERT_EQ(r.result.prediction.frames(), 60);
    if (r.person != "a") continue;
    const auto end = static_cast<int64_t>(std::round((r.time - 1.7e9) * 30)) + 1;
    forecast::Options options;
    options.standard = true;
    options.refine = false;
    const forecast::Result expected = forecaster()->run(slice(walk(), end - 30, end), walk_room(), options);
    EXPECT_LT(largest_difference(r.result.forecast.joints, expected.forecast.joints), 1e-5F) << end;
    EXPECT_TRUE(torch::equal(r.result.prediction.joints, r.result.forecast.joints));
    ++compared;
  }
  EXPECT_EQ(compared, 5);
  EXPECT_EQ(results.size(), 9);
}

TEST(ForecastStream, WhatWasForecastBeforeLeavesNoTrace) {
  const auto joints = [](int64_t end) {
    return forecaster()->run(slice(walk(), end - 30, end), walk_room(), {.joints_alone = true}).forecast.joints;
  };
  std::map<int64_t, torch::Tensor> first;
  for (const int64_t end : {30, 45, 60, 75, 90, 90, 75, 45, 60, 30, 45}) {
    const torch::Tensor now = joints(end);
    const auto known = first.emplace(end, now).first;
    EXPECT_LT(largest_difference(now, known->second), 1e-5F) << end;
  }
}

TEST(ForecastStream, WholeForecastsAreThoseOfTheFacade) {
  ForecastStream stream(forecaster(), walk_room(), {.poses = {.rate = 1}, .forecast = {.points = 500}});
  for (int64_t t = 0; t < 30; ++t) stream.push("a", static_cast<double>(t) / 30, walk().joints[t]);
  const auto results = stream.take();
  ASSERT_EQ(results.size(), 1);
  const forecast::Result expected = forecaster()->run(slice(walk(), 0, 30), walk_room(), {.points = 500});
  EXPECT_LT(largest_difference(results[0].result.prediction.joints, expected.prediction.joints), 1e-4F);
  EXPECT_TRUE(results[0].result.prediction.rotations.defined());
}

TEST(ForecastStream, WhoCannotBeForecastSaysWhyAndOthersAre) {
  ForecastStream stream(forecaster(), walk_room());
  for (int64_t t = 0; t < 30; ++t) {
    const double time = static_cast<double>(t) / 30;
    stream.push("away", time, walk().joints[t] + 200);
    stream.push("here", time, walk().joints[t]);
  }
  const auto results = stream.take();
  ASSERT_EQ(results.size(), 2);
  EXPECT_THAT(results[0].error, HasSubstr("lies within 2.50 m"));
  EXPECT_EQ(results[1].error, "");
  EXPECT_EQ(results[1].result.forecast.joints.size(0), 60);
}

// A tracker's glitch: bones of 30 to 1000 m, which float32 cannot hold beside the others.
TEST(ForecastStream, AJointThatIsFarOffEndsNobodyElsesForecast) {
  for (const float far : {30.F, 100.F, 1000.F}) {
    ForecastStream stream(forecaster(), walk_room(), {.poses = {.rate = 30}});
    int forecasts = 0;
    for (int64_t t = 0; t < 40; ++t) {
      torch::Tensor joints = walk().joints[t].clone();
      if (t == 30) joints[7] += far;
      stream.push("a", static_cast<double>(t) / 30, joints);
      stream.push("b", static_cast<double>(t) / 30, walk().joints[t]);
      for (const auto& r : stream.take()) {
        if (r.person != "b") continue;
        EXPECT_EQ(r.error, "");
        ++forecasts;
      }
    }
    EXPECT_GE(forecasts, 10) << far;
  }
}

TEST(ForecastStream, HundredsOfForecastsTakeNoMemory) {
  ForecastStream stream(forecaster(), walk_room(),
                        {.poses = {.rate = 10}, .forecast = {.points = 64, .joints_alone = true}});
  const auto seconds = [&](int64_t first, int64_t last) {
    for (int64_t i = first * 30; i < last * 30; ++i) {
      stream.push("a", static_cast<double>(i) / 30, walk().joints[i % 90 < 60 ? 30 + i % 60 : 89]);
      for (const auto& r : stream.take()) EXPECT_EQ(r.error, "");
    }
  };
  seconds(0, 6);
  const size_t before = mallinfo2().uordblks + mallinfo2().hblkhd;
  seconds(6, 36);
  EXPECT_LT(static_cast<double>(mallinfo2().uordblks + mallinfo2().hblkhd), static_cast<double>(before) + 256e3);
}

TEST(AnticipateStream, SaysWhatTheFacadeSaysOfTheSameWindow) {
  AnticipateStream stream(anticipator());
  std::vector<anticipate::StreamResult> results;
  for (int64_t t = 0; t < 90; ++t) {  // taken for a recording at the model's 25 Hz
    stream.push("a", static_cast<double>(t) / 25, walk().joints[t]);
    for (auto& r : stream.take()) results.push_back(std::move(r));
  }
  ASSERT_EQ(results.size(), 7);
  Clip clip = walk();
  clip.rate = 25;
  for (const auto& r : results) {
    ASSERT_EQ(r.error, "");
    const auto end = static_cast<int64_t>(std::round(r.time * 25)) + 1;
    const anticipate::Result expected = anticipator()->run(slice(clip, std::max<int64_t>(0, end - 50), end), {},
                                                           {.samples = 5, .seconds = 2, .standard = true});
    ASSERT_EQ(r.result.futures.size(), 5);
    for (size_t s = 0; s < 5; ++s)
      EXPECT_LT(largest_difference(r.result.futures[s].joints, expected.futures[s].joints), 1e-4F) << end;
  }
  EXPECT_NEAR(results[0].time, 7.0 / 25, 1e-9) << "as soon as eight frames were seen";
}

TEST(AnticipateStream, RefusesOptionsAtOnce) {
  anticipate::StreamOptions options;
  options.anticipate.samples = 0;
  EXPECT_THAT(refusal_of([&] { AnticipateStream(anticipator(), options); }), HasSubstr("samples"));
  options.anticipate = {.seconds = 1e9};
  EXPECT_THAT(refusal_of([&] { AnticipateStream(anticipator(), options); }), HasSubstr("seconds"));
}

}  // namespace
}  // namespace inhabit
