// Protects the detection of contacts: a foot that stands is found from touch-down to lift-off, one that glides or is
// in the air is not, slow steps come out as two contacts, and noise of a centimetre changes little once smoothed; palms
// that rest on a surface are found, those that slide over it or float are not.
#include "inhabit/refine/contacts.h"

#include <gtest/gtest.h>

#include <random>

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr double kRate = 30;

/// Stands for `stand` frames, swings a stride of `stride` metres in `swing` frames, and so on.
Track steps(int64_t frames, int64_t stand, int64_t swing, double stride) {
  Track out;
  Vector3d at(0, 0.02, 0);
  for (int64_t t = 0; t < frames; ++t) {
    const int64_t phase = t % (stand + swing);
    const double part = phase < stand ? 0 : static_cast<double>(phase - stand + 1) / static_cast<double>(swing);
    const double along = part * part * (3 - 2 * part);
    out.push_back(at + Vector3d(stride * along, 0.1 * std::sin(M_PI * part), 0));
    if (phase == stand + swing - 1) at.x() += stride;
  }
  return out;
}

std::vector<Contact> found(const Track& track) {
  const std::vector<double> floor(track.size(), 0);
  return detect_contacts(10, track, floor, standing_height(track, floor), kRate);
}

TEST(Contacts, StandsAreFound) {
  const std::vector<Contact> contacts = found(steps(100, 18, 12, 1.2));
  ASSERT_EQ(contacts.size(), 4U);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(static_cast<double>(contacts[i].first), 30.0 * i, i == 0 ? 0 : 2);
    EXPECT_NEAR(static_cast<double>(contacts[i].last), i < 3 ? 30.0 * i + 17 : 99, 2);
  }
}

TEST(Contacts, WhatGlidesOrIsInTheAirIsNone) {
  Track glides, floats;
  for (int t = 0; t < 60; ++t) {
    glides.emplace_back(0.02 * t, 0.02, 0);
    floats.emplace_back(0, t < 5 ? 0.02 : 0.3, 0);
  }
  EXPECT_TRUE(found(glides).empty());
  const std::vector<Contact> contacts = found(floats);
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_LT(contacts[0].last, 5);
}

TEST(Contacts, ThatANetworkPredictsAreTakenWhereTheFootIsLowAndNear) {
  Track track;  // glides by 1 cm a frame for 10 frames, then is lifted and goes on
  std::vector<float> told;
  for (int64_t t = 0; t < 40; ++t) {
    const double later = std::max<double>(0, static_cast<double>(t) - 10);
    track.emplace_back(0.01 * static_cast<double>(std::min<int64_t>(t, 10)) + 0.1 * later, t < 12 ? 0.02 : 0.2, 0);
    told.push_back(t < 20 || t == 30 ? 0.9F : 0.1F);
  }
  const std::vector<double> floor(track.size(), 0);
  const std::vector<Contact> contacts = predicted_contacts(10, told, track, floor, 0.02, kRate);
  ASSERT_EQ(contacts.size(), 1U) << "a frame in the air is none";
  EXPECT_EQ(contacts[0].joint, 10);
  EXPECT_EQ(contacts[0].first, 0) << "a foot that glides is told to stand";
  EXPECT_EQ(contacts[0].last, 11) << "one that is lifted does not";
  EXPECT_TRUE(found(track).empty() || found(track)[0].last < 11) << "by its motion it would not stand so long";
  EXPECT_TRUE(predicted_contacts(10, std::vector<float>(40, 0.4F), track, floor, 0.02, kRate).empty());
}

TEST(Contacts, AreExtendedWhileTheFootIsLowAndNearAndNoFarther) {
  Track track;
  for (int64_t t = 0; t < 40; ++t)  // stands for 20 frames, glides 3 cm a frame for 6, is lifted
    track.emplace_back(t < 20 ? 0 : 0.03 * static_cast<double>(t - 19), t < 26 ? 0.02 : 0.2, 0);
  const std::vector<double> floor(track.size(), 0);
  std::vector<Contact> near = {{10, 5, 15}}, low = near, two = {{10, 0, 8}, {10, 12, 18}};
  extend_contacts(near, track, floor, 0.02, 0.035, 0.1);
  EXPECT_EQ(near[0].first, 0);
  EXPECT_EQ(near[0].last, 22) << "9 cm away";
  extend_contacts(low, track, floor, 0.02, 0.035, 10);
  EXPECT_EQ(low[0].last, 25) << "the last low frame";
  extend_contacts(two, track, floor, 0.02, 0.035, 0.1);
  EXPECT_LT(two[0].last, two[1].first - 1) << "two contacts stay two";
}

TEST(Contacts, ASlowStepParts) {
  const std::vector<Contact> contacts = found(steps(50, 20, 12, 0.12));  // never above half a metre a second
  ASSERT_EQ(contacts.size(), 2U);
  EXPECT_LT(contacts[0].last, contacts[1].first - 3);
}

TEST(Contacts, NoiseIsSmoothedAway) {
  const Track clean = steps(120, 18, 12, 1.2);
  Track noisy = clean;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 0.01);
  for (Vector3d& p : noisy)
    for (double& x : p) x += normal(random);
  const std::vector<Contact> expected = found(clean), contacts = found(smoothed(noisy, kRate, 0.35));
  ASSERT_EQ(contacts.size(), expected.size());
  for (size_t i = 0; i < contacts.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(contacts[i].first), static_cast<double>(expected[i].first), 3);
    EXPECT_LT((contact_place(contacts[i], noisy) - contact_place(expected[i], clean)).norm(), 0.012);
  }
}

TEST(Contacts, PalmsThatRestOnASurface) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 0.005);
  Track rests, slides, floats;
  std::vector<double> on, above;
  for (int t = 0; t < 90; ++t) {  // comes at half a metre a second, rests for a second, and goes as it came
    const double away = std::max({0, 30 - t, t - 59}) / 60.0;
    rests.emplace_back(0.1 + away, 0.7 + away, 0);
    slides.emplace_back(0.12 * t / kRate, 0.7, 0);
    floats.emplace_back(0.1, 0.7, 0);
    for (double& x : rests.back()) x += normal(random);
    on.push_back(0.01);
    above.push_back(0.06);
  }
  const Track smooth = smoothed(rests, kRate, kPalmSmoothing);
  std::vector<double> distances;
  for (const Vector3d& p : smooth) distances.push_back(std::abs(p.y() - 0.7));
  const std::vector<Contact> contacts = detect_palm_contacts(20, smooth, distances, kRate);
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(contacts[0].joint, 20);
  EXPECT_NEAR(static_cast<double>(contacts[0].first), 30, 4);
  EXPECT_NEAR(static_cast<double>(contacts[0].last), 59, 4);
  EXPECT_TRUE(detect_palm_contacts(20, slides, on, kRate).empty());
  EXPECT_TRUE(detect_palm_contacts(20, floats, above, kRate).empty());
  EXPECT_EQ(detect_palm_contacts(20, floats, on, kRate).size(), 1U);
}

TEST(Contacts, SmoothingKeepsStraightLinesAndTakesNoise) {
  Track line, jitter;
  for (int t = 0; t < 40; ++t) {
    line.emplace_back(0.1 * t, 1 - 0.05 * t, 2);
    jitter.emplace_back(t % 2 == 0 ? 0.01 : -0.01, 0, 0);
  }
  const Track kept = smoothed(line, kRate, 0.5), gone = smoothed(jitter, kRate, 0.5);
  for (size_t t = 0; t < 40; ++t) {
    EXPECT_LT((kept[t] - line[t]).norm(), 1e-9);
    EXPECT_LT(gone[t].norm(), 3e-3);
  }
}

}  // namespace
}  // namespace inhabit::refine
