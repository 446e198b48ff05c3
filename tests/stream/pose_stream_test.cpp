// Protects when people's results are due, how many people there may be, and that hours of poses take no memory.
#include "inhabit/motion/pose_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include "poses.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

using testing::HasSubstr;

size_t heap_bytes() { return mallinfo2().uordblks + mallinfo2().hblkhd; }

/// The times at which a person's results were taken.
std::vector<double> results(PoseStream& stream, double from, double to, double input_rate) {
  std::vector<double> out;
  const auto count = static_cast<int64_t>(std::round((to - from) * input_rate));
  for (int64_t i = 0; i < count; ++i) {
    stream.push("a", from + static_cast<double>(i) / input_rate, walk().joints[i % 90]);
    for (const auto& due : stream.take()) out.push_back(due.time);
  }
  return out;
}

TEST(PoseStream, ResultsComeAtTheRateOnceEnoughWasSeen) {
  PoseStream stream({.rate = 10}, 29.0 / 30, 29.0 / 30);
  const std::vector<double> times = results(stream, 0, 3, 30);
  ASSERT_EQ(times.size(), 21);
  for (size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], (29 + 3 * static_cast<double>(i)) / 30, 1e-9);
  PoseStream slow({.rate = 10}, 29.0 / 30, 29.0 / 30);
  EXPECT_EQ(results(slow, 0, 3, 7).size(), 14) << "poses come more slowly than results are wanted: one for each";
  PoseStream odd({.rate = 10}, 29.0 / 30, 29.0 / 30);
  EXPECT_NEAR(static_cast<double>(results(odd, 0, 21, 47).size()), 200, 2) << "the mean rate is met between odd times";
  PoseStream each({.rate = std::numeric_limits<double>::infinity()}, 29.0 / 30, 29.0 / 30);
  EXPECT_EQ(results(each, 0, 3, 30).size(), 61);
}

TEST(PoseStream, AGapEndsWhatIsDue) {
  PoseStream stream({.rate = 10}, 1, 1);
  for (int i = 0; i <= 30; ++i) stream.push("a", i / 30.0, walk().joints[i]);
  EXPECT_TRUE(stream.due("a"));
  EXPECT_FALSE(stream.due("b"));
  stream.push("a", 5, walk().joints[0]);
  EXPECT_FALSE(stream.due("a"));
  EXPECT_TRUE(stream.take().empty());
  for (int i = 1; i <= 30; ++i) stream.push("a", 5 + i / 30.0, walk().joints[i]);
  ASSERT_EQ(stream.take().size(), 1);
}

TEST(PoseStream, PeopleAreKeptApartAndMakeRoomWhenTheyAreGone) {
  PoseStream stream({.rate = 1, .people = 2, .forget = 3}, 1, 1);
  for (int i = 0; i <= 30; ++i) {
    stream.push("a", i / 30.0, walk().joints[i]);
    stream.push("b", 7 + i / 30.0, walk().joints[89 - i]);
  }
  const auto due = stream.take();
  ASSERT_EQ(due.size(), 2);
  EXPECT_EQ(due[0].person, "a");
  EXPECT_EQ(due[1].time, 8);
  EXPECT_TRUE(torch::equal(due[1].window->clip(30, 1).joints[0], walk().joints[59]));
  EXPECT_EQ(refusal_of([&] { stream.push("c", 2, walk().joints[0]); }), "person: there are 2 people already");
  stream.push("c", 8, walk().joints[0]);  // a was seen last at 1
  EXPECT_EQ(stream.people(), 2);
  EXPECT_THAT(refusal_of([&] { stream.push("d", 8, torch::full({22, 3}, NAN)); }), HasSubstr("neither"));
  EXPECT_EQ(stream.people(), 2) << "who is refused makes nobody go";
}

// A recording that is played again from its start, or a simulator that is reset.
TEST(PoseStream, NewPeopleAreLetInAfterTheClockJumpsBack) {
  PoseStream stream({.rate = 1, .people = 3, .forget = 3}, 1, 1);
  for (int i = 0; i < 3; ++i) stream.push(std::to_string(i), 1000 + i, walk().joints[0]);
  EXPECT_EQ(refusal_of([&] { stream.push("new", 0, walk().joints[0]); }), "person: there are 3 people already");
  stream.push("new", 0.03, walk().joints[1]);
  EXPECT_EQ(stream.people(), 1);
  PoseStream known({.rate = 1, .people = 3, .forget = 3}, 1, 1);
  for (int i = 0; i < 3; ++i) known.push(std::to_string(i), 1000 + i, walk().joints[0]);
  known.push("2", 0, walk().joints[0]);
  known.push("new", 0.03, walk().joints[0]);
  EXPECT_EQ(known.people(), 2);
}

TEST(PoseStream, OtherNamesInAnyOrder) {
  PoseStreamOptions options;
  options.names.assign(standard_joint_names().rbegin(), standard_joint_names().rend());
  PoseStream stream(options, 1, 0);
  stream.push("a", 0, walk().joints[5].flip(0));
  const Clip clip = stream.take().at(0).window->clip(30, 1);
  for (int j = 0; j < 22; ++j)
    EXPECT_TRUE(torch::equal(clip.joints[0][clip.skeleton.find(standard_joint_names()[static_cast<size_t>(j)])],
                             walk().joints[5][j]));
}

TEST(PoseStream, FiveHoursOfTenPeopleTakeNoMemory) {
  PoseStream stream({.rate = 0.05}, 29.0 / 30, 29.0 / 30);
  std::vector<torch::Tensor> poses;
  for (int64_t i = 0; i < 90; ++i) poses.push_back(walk().joints[i].contiguous());
  int64_t looked_at = 0;
  const auto minutes = [&](int first, int last) {
    for (int64_t i = int64_t{first} * 600; i < int64_t{last} * 600; ++i)
      for (int p = 0; p < 10; ++p) {
        const auto k = static_cast<size_t>((i + 9 * p) % 90);
        stream.push(std::to_string(p), static_cast<double>(i) / 10, poses[k]);
        for (const auto& due : stream.take()) looked_at += due.window->clip(30, 30).frames();
      }
  };
  minutes(0, 5);
  const size_t before = heap_bytes();
  minutes(5, 305);
  EXPECT_LT(static_cast<double>(heap_bytes()), static_cast<double>(before) + 64e3);
  EXPECT_NEAR(static_cast<double>(looked_at), 10 * 305 * 3 * 30, 30 * 20);
}

TEST(PoseStream, RefusesOptionsThatMakeNoSense) {
  const auto refusal = [](const PoseStreamOptions& options, double seconds = 1) {
    return refusal_of([&] { PoseStream(options, seconds, seconds); });
  };
  EXPECT_THAT(refusal({.rate = 0}), HasSubstr("rate"));
  EXPECT_THAT(refusal({.rate = NAN}), HasSubstr("rate"));
  EXPECT_THAT(refusal({.longest_gap = -1}), HasSubstr("gap"));
  EXPECT_THAT(refusal({.people = 0}), HasSubstr("people"));
  EXPECT_THAT(refusal({.forget = NAN}), HasSubstr("forget"));
  EXPECT_THAT(refusal({}, 1e9), HasSubstr("seconds"));
}

}  // namespace
}  // namespace inhabit
