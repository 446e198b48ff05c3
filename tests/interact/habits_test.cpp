// Protects what people who sit or stand do while no contact says: that it is what the recorded ones do a second later,
// as seen from their own axes, and that it is carried over to another chair, place and body.
#include "inhabit/interact/habits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "inhabit/interact/features.h"
#include "inhabit/interact/sample.h"
#include "interact/sitter_data.h"
#include "temp_folder.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3f;

/// Sitters who hold on to nothing: on the seat from frame 90 to 149.
class SeatedHabitsOf : public testing::Test {
 protected:
  static constexpr int64_t kFirst = 90, kLast = 149;

  SeatedHabitsOf() {
    Dataset set = create_dataset(folder_ / "sitters", Sitter().clip.action_names);
    write_scene(set, "seat.glb", seat_scene());
    Clip clip = Sitter().clip;
    clip.hand_targets.zero_();
    clip.joints.slice(0, 100, 150).select(1, 15).add_(0.1);  // the head moves while they sit
    set.clips.push_back({"clip.npz", "seat.glb", "train", 0, ""});
    write_clip(set, set.clips.back(), clip);
    write_index(set);
    data_ = std::make_unique<Data>(std::vector<std::string>{folder_ / "sitters"}, "train", config_, false);
  }
  const Recording::Frame& frame(int64_t t) const { return data_->recording(0).frames[static_cast<size_t>(t)]; }

  TempFolder folder_;
  Config config_ = preset("compact");
  std::unique_ptr<Data> data_;
};

TEST_F(SeatedHabitsOf, IsKnownWhileTheyStay) {
  for (int64_t t = 0; t < Sitter::kFrames; ++t) {
    const AheadPose ahead = state_at(data_->recording(0), t).ahead;
    ASSERT_EQ(ahead.known, t >= kFirst && t + 30 <= kLast) << t;
    if (!ahead.known) continue;
    EXPECT_EQ(ahead.head, frame(t + 30).position[15]);
    EXPECT_EQ(ahead.ankle[1], frame(t + 30).position[8]);
    EXPECT_EQ(ahead.palm[0], frame(t + 30).sample.hand[0]);
    EXPECT_TRUE(ahead.free[0] && ahead.free[1]);
  }
}

TEST_F(SeatedHabitsOf, HandsAtContactsAreTold) {
  const Recording held = [] {
    const Sitter sitter;  // the left hand holds on from frame 90 to 119
    return record(sitter.clip, label(sitter.clip, chair_of(sitter.clip, seat_scene())), "sitter");
  }();
  EXPECT_FALSE(state_at(held, 100).ahead.known) << "the contact says what they do";
}

TEST_F(SeatedHabitsOf, AreSeenFromTheirOwnAxes) {
  State state = state_at(data_->recording(0), 95);
  const InputLayout layout = input_layout(config_);
  std::vector<float> x(static_cast<size_t>(layout.size), NAN);
  state.ahead.free[0] = false;
  build_input(layout, state, data_->senses(0), x.data());
  const float* told = x.data() + layout.ahead.first;
  ASSERT_EQ(layout.ahead.size, kAheadSize);
  EXPECT_EQ(told[0], 1);
  const auto place = [&](int at) { return Vector3f(told[at], told[at + 1], told[at + 2]); };
  const Place root = state.now().root;
  const auto goes = [&](const Vector3f& told_move, const Vector3f& from, const Vector3f& to) {
    return (from + root.turned_out(told_move) - to).norm();
  };
  EXPECT_GT((frame(125).position[15] - frame(95).position[15]).norm(), 0.1F);
  EXPECT_LT(goes(place(1), frame(95).position[15], frame(125).position[15]), 1e-4F);
  EXPECT_LT(goes(place(7), frame(95).position[8], frame(125).position[8]), 1e-4F);
  EXPECT_EQ(told[10], 1);  // right
  EXPECT_LT(goes(place(11), frame(95).sample.hand[1], frame(125).sample.hand[1]), 1e-4F);
  for (int i = 14; i < kAheadSize; ++i) EXPECT_EQ(told[i], 0) << "the left hand is not free";
  build_input(layout, state_at(data_->recording(0), 20), data_->senses(0), x.data());
  for (int i = 0; i < kAheadSize; ++i) EXPECT_EQ(told[i], 0) << "they walk";
}

TEST_F(SeatedHabitsOf, AreLivedFrameByFrameAgainAndAgain) {
  const Habits habits = habits_of(*data_, 10, 10);
  ASSERT_EQ(habits.seated.size(), 1);
  const ChairGrid& chair = data_->senses(0).chair;
  std::mt19937_64 random(1);
  SeatedLife same(habits, chair, 0.45);
  const auto state = [&](int64_t k) { return state_at(data_->recording(0), kFirst + k); };
  for (const int64_t begin : {0, 1})
    for (int64_t k = 0; k < 25; ++k) {  // a second on is the last row, of frame 145
      const AheadPose ahead = same.next(state(k), random);
      ASSERT_TRUE(ahead.known);
      if (k % kKeyStep != 0) continue;
      EXPECT_LT((ahead.head - frame(kFirst + k + 30).position[15]).norm(), 1e-4F) << begin << " " << k;
      EXPECT_LT((ahead.ankle[0] - frame(kFirst + k + 30).position[7]).norm(), 1e-4F);
      EXPECT_LT((ahead.palm[1] - frame(kFirst + k + 30).sample.hand[1]).norm(), 1e-4F);
    }
  ChairGrid there = chair;
  there.seat.position += Eigen::Vector2f(3, 1);
  SeatedLife higher(habits, there, 0.55);
  State moved = state(0);
  for (Vector3f& p : moved.position) p += Vector3f(3, p.y() > 0.3F ? 0.1F : 0, 1);
  const AheadPose ahead = higher.next(moved, random);
  EXPECT_LT((ahead.head - frame(kFirst + 30).position[15] - Vector3f(3, 0.1F, 1)).norm(), 1e-4F);
  EXPECT_LT((ahead.ankle[0] - frame(kFirst + 30).position[7] - Vector3f(3, 0, 1)).norm(), 1e-4F) << "on the floor";
  // Who is elsewhere moves alike and comes a tenth nearer.
  State aside = state(0);
  aside.position[15].x() += 0.1F;
  SeatedLife drawn(habits, chair, 0.45);
  EXPECT_LT((drawn.next(aside, random).head - frame(kFirst + 30).position[15] - Vector3f(0.09F, 0, 0)).norm(), 1e-4F);
}

TEST_F(SeatedHabitsOf, OfAFileMayBeShort) {
  Habits habits = habits_of(*data_, 1, 0);
  habits.seated.points = habits.seated.points.slice(0, 0, 2).contiguous();
  habits.seated.ends = torch::tensor({int64_t{2}});
  std::mt19937_64 random(1);
  SeatedLife life(habits, data_->senses(0).chair, 0.45);
  for (int k = 0; k < 40; ++k) EXPECT_TRUE(life.next(state_at(data_->recording(0), 95), random).head.allFinite());
}

TEST_F(SeatedHabitsOf, AreThoseOfChairsThatAreMostAlike) {
  // Twenty stays on seats from 0.3 m to 0.68 m; sixteen are drawn from.
  const Habits one = habits_of(*data_, 1, 0);
  Habits many;
  const int64_t rows = one.seated.points.size(0);
  many.chairs = one.chairs.repeat({20, 1});
  many.heights = 0.3 + 0.02 * torch::arange(20);
  many.seated.ends = (torch::arange(20) + 1) * rows;
  many.seated.points = one.seated.points.repeat({20, 1});
  for (int64_t i = 0; i < 20; ++i)
    many.seated.points.slice(0, i * rows, (i + 1) * rows).select(1, 1).fill_(i);  // the head's height
  std::mt19937_64 random(2);
  SeatedLife life(many, data_->senses(0).chair, 0.3);
  std::set<int> drawn;
  State state = state_at(data_->recording(0), kFirst);
  state.position[15].y() = 0;
  for (int k = 0; k < 20000; ++k)  // a tenth of the distance from height 0
    drawn.insert(static_cast<int>(std::lround((life.next(state, random).head.y() - 0.03F) / 0.1F)));
  EXPECT_EQ(drawn.size(), 16U);
  EXPECT_EQ(*drawn.rbegin(), 15);
}

/// Two people of one data set who stand about for three seconds and walk on: the second is a fifth taller.
class StandingHabitsOf : public testing::Test {
 protected:
  static constexpr int64_t kStand = 90;

  StandingHabitsOf() {
    Dataset set = create_dataset(folder_ / "standing", Sitter().clip.action_names);
    write_scene(set, "seat.glb", seat_scene());
    Clip clip = Sitter().clip;
    clip.hand_targets.zero_();
    clip.contact.zero_();  // nobody sits
    const auto walk = static_cast<int64_t>(std::find(clip.action_names.begin(), clip.action_names.end(), "walk") -
                                           clip.action_names.begin());
    const auto stand = static_cast<int64_t>(std::find(clip.action_names.begin(), clip.action_names.end(), "stand") -
                                            clip.action_names.begin());
    clip.action.fill_(walk);
    // They arrive and stand where they are at the end; their head leans aside there.
    const int64_t first = clip.frames() - kStand;
    clip.action.slice(0, first).fill_(stand);
    clip.joints.slice(0, first).copy_(clip.joints.slice(0, 0, 1).clone().expand({kStand, -1, -1}));
    clip.joints.slice(0, first + 40).select(1, 15).select(1, 0).add_(0.06);
    set.clips.push_back({"clip.npz", "seat.glb", "train", 0, ""});
    write_clip(set, set.clips.back(), clip);
    write_index(set);
    data_ = std::make_unique<Data>(std::vector<std::string>{folder_ / "standing"}, "train", config_, false);
    first_ = first;
  }
  State state(int64_t t) const { return state_at(data_->recording(0), t); }

  TempFolder folder_;
  Config config_ = preset("compact");
  std::unique_ptr<Data> data_;
  int64_t first_ = 0;
};

TEST_F(StandingHabitsOf, IsKnownWhileTheyStandAndHaveNowhereToGo) {
  const auto known = [&](int64_t t) { return state(t).ahead.known; };
  EXPECT_FALSE(known(first_ - 20)) << "they walk";
  EXPECT_TRUE(known(first_ + 10));
  EXPECT_NEAR((state(first_ + 20).ahead.head - state(first_ + 20).position[15]).x(), 0.06F, 1e-5F);
}

TEST_F(StandingHabitsOf, AreLivedByOthersWhereTheyStand) {
  const Habits habits = habits_of(*data_, 10, 10);
  EXPECT_EQ(habits.seated.size(), 0);
  ASSERT_EQ(habits.standing.size(), 1);
  // Somebody a fifth taller at another place, who looks the other way, with feet a little wider apart.
  State other = state(first_ + 10);
  for (Eigen::Vector3f& p : other.position) p = Vector3f(-1.2F * p.x() + 3, 1.2F * p.y(), -1.2F * p.z() - 2);
  for (Sample& s : other.samples) {
    s.root.position = -1.2F * s.root.position + Eigen::Vector2f(3, -2);
    s.root.facing = -s.root.facing;
    for (Vector3f& p : s.hand) p = Vector3f(-1.2F * p.x() + 3, 1.2F * p.y(), -1.2F * p.z() - 2);
  }
  other.position[7].x() -= 0.02F;
  other.position[8].x() += 0.02F;
  std::mt19937_64 random(3);
  StandingLife life(habits);
  float least = 0;
  for (int64_t k = 0; k < 80; ++k) {
    const AheadPose ahead = life.next(other, random);
    ASSERT_TRUE(ahead.known);
    least = std::min(least, (ahead.head - other.position[15]).x());
    for (size_t side = 0; side < 2; ++side)
      EXPECT_LT((ahead.ankle[side] - other.position[7 + side]).norm(), 1e-5F) << "feet stay where they are";
  }
  EXPECT_NEAR(least, -1.2F * 0.06F, 0.002F) << "as far aside for their height, seen from the other side";
}

}  // namespace
}  // namespace inhabit::interact
