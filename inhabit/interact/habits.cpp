#include "inhabit/interact/habits.h"

#include <algorithm>
#include <numeric>

#include "inhabit/interact/features.h"
#include "inhabit/interact/sample.h"
#include "inhabit/math/random.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3f;

constexpr int64_t kPoints = 5;      // head, ankles, palms
constexpr int64_t kLeastStay = 60;  // frames
constexpr int64_t kAlike = 16;      // seated stays that one is drawn from
constexpr float kHeightCounts = 2;  // a metre of the seat's height, against one of all numbers of its grid
constexpr float kPull = 0.1F;       // fraction of the distance to where the recorded person is, each second
constexpr int64_t kAhead = kSamples - 1 - kNow;

/// A stay of a recording: frames [first, end).
struct StaySpan {
  int64_t clip, first, end;
};

/// Stays of frames of which `stays` is true, at most `count` of them.
template <class Predicate>
std::vector<StaySpan> spans_of(const Data& data, int64_t count, const Predicate& stays) {
  std::vector<StaySpan> all, out;
  for (int64_t clip = 0; clip < data.clips(); ++clip) {
    const Recording& r = data.recording(clip);
    for (int64_t t = 0; t < r.size();) {
      int64_t end = t;
      while (end < r.size() && stays(r.frames[static_cast<size_t>(end)])) ++end;
      if (end - t >= kLeastStay) all.push_back({clip, t, end});
      t = end + 1;
    }
  }
  for (const int64_t i : spread_indices(static_cast<int64_t>(all.size()), count))
    out.push_back(all[static_cast<size_t>(i)]);
  return out;
}

std::array<Vector3f, kPoints> points_of(const Recording::Frame& f) {
  return {f.position[15], f.position[7], f.position[8], f.sample.hand[0], f.sample.hand[1]};
}

/// Points of all spans, each moved by move(span, k, point).
template <class Move>
StayPoints gather_points(const Data& data, const std::vector<StaySpan>& spans, const Move& move) {
  std::vector<float> points;
  std::vector<int64_t> ends;
  for (const StaySpan& span : spans) {
    const Recording& r = data.recording(span.clip);
    for (int64_t t = span.first; t < span.end; t += kKeyStep) {
      const auto places = points_of(r.frames[static_cast<size_t>(t)]);
      for (int64_t k = 0; k < kPoints; ++k) {
        const Vector3f p = move(span, k, places[static_cast<size_t>(k)]);
        points.insert(points.end(), p.data(), p.data() + 3);
      }
    }
    ends.push_back(static_cast<int64_t>(points.size()) / (3 * kPoints));
  }
  if (ends.empty()) return {};
  return {torch::tensor(ends), torch::tensor(points).view({-1, 3 * kPoints})};
}

bool over_seat(int64_t point) { return point == 0 || point > 2; }

/// The root's axes, between the ankles.
Place stance_of(const Place& root, const Vector3f& left_ankle, const Vector3f& right_ankle) {
  const Vector3f middle = (left_ankle + right_ankle) / 2;
  return {{middle.x(), middle.z()}, root.facing};
}

/// Where somebody is to be a second from now: as far away as the recorded person goes, and kPull of the distance to
/// where that person then is. @param place place(k, ahead): the recorded person's point k in the world, `ahead` frames
/// on
template <class Where>
AheadPose gone_along(const State& state, const Where& place) {
  const auto goal = [&](int64_t k, const Vector3f& now) -> Vector3f {
    const Vector3f then = place(k, kAhead);
    return now + (1 - kPull) * (then - place(k, 0)) + kPull * (then - now);
  };
  return {true,
          goal(0, state.position[15]),
          {goal(1, state.position[7]), goal(2, state.position[8])},
          {goal(3, state.now().hand[0]), goal(4, state.now().hand[1])},
          {true, true}};
}

/// The seated stays on the chairs that are most like one.
std::vector<int64_t> stays_alike(const Habits& habits, const ChairGrid& chair, double seat_height) {
  torch::Tensor own = torch::empty({habits.chairs.size(1)});
  contact_condition(chair, own.data_ptr<float>());
  const torch::Tensor order =
      ((habits.chairs - own).abs().mean(1) + kHeightCounts * (habits.heights - seat_height).abs())
          .argsort()
          .contiguous();
  const int64_t* first = order.data_ptr<int64_t>();
  return {first, first + std::min<int64_t>(kAlike, order.size(0))};
}

std::vector<int64_t> every_stay(const StayPoints& stays) {
  std::vector<int64_t> out(static_cast<size_t>(stays.size()));
  std::iota(out.begin(), out.end(), 0);
  return out;
}

}  // namespace

Habits habits_of(const Data& data, int64_t seated, int64_t standing) {
  const auto frame = [&](const StaySpan& span) -> const Recording::Frame& {
    return data.recording(span.clip).frames[static_cast<size_t>(span.first)];
  };
  const std::vector<StaySpan> sitting = spans_of(data, seated, [](const Recording::Frame& f) { return f.seated; });
  Habits out;
  std::vector<torch::Tensor> chairs;
  std::vector<float> heights;
  for (const StaySpan& span : sitting) {
    chairs.push_back(torch::empty({data.config().chair_size()}));
    contact_condition(data.senses(span.clip).chair, chairs.back().data_ptr<float>());
    heights.push_back(frame(span).sample.goal.y());
  }
  if (!sitting.empty()) out.chairs = torch::stack(chairs), out.heights = torch::tensor(heights);
  out.seated = gather_points(data, sitting, [&](const StaySpan& span, int64_t k, const Vector3f& point) {
    Vector3f p = data.senses(span.clip).chair.seat.in(point);
    if (over_seat(k)) p.y() -= frame(span).sample.goal.y();
    return p;
  });
  out.standing = gather_points(data, spans_of(data, standing, stands),
                               [&](const StaySpan& span, int64_t, const Vector3f& point) -> Vector3f {
                                 const Recording::Frame& f = frame(span);
                                 const Place place = stance_of(f.sample.root, f.position[7], f.position[8]);
                                 return place.in(point) / f.position[15].y();
                               });
  return out;
}

bool StayWalk::advance(std::mt19937_64& random) {
  ++passed_;
  if (stay_ >= 0 && passed_ + kAhead < (last() - begin()) * kKeyStep) return false;
  stay_ = drawn_[static_cast<size_t>(uniform_int(random, 0, static_cast<int>(drawn_.size()) - 1))];
  passed_ = 0;
  return true;
}

Vector3f StayWalk::point(int64_t k, int64_t ahead) const {
  const int64_t frame = passed_ + ahead, row = std::min(begin() + frame / kKeyStep, last()),
                after = std::min(row + 1, last());
  const float part = static_cast<float>(frame % kKeyStep) / kKeyStep;
  const float* points = stays_.points.data_ptr<float>();
  const Eigen::Map<const Vector3f> a(points + (row * kPoints + k) * 3), b(points + (after * kPoints + k) * 3);
  return (1 - part) * a + part * b;
}

SeatedLife::SeatedLife(const Habits& habits, const ChairGrid& chair, double seat_height)
    : walk_(habits.seated, stays_alike(habits, chair, seat_height)),
      seat_(chair.seat),
      height_(static_cast<float>(seat_height)) {}

AheadPose SeatedLife::next(const State& state, std::mt19937_64& random) {
  walk_.advance(random);
  return gone_along(state, [&](int64_t k, int64_t ahead) {
    Vector3f p = walk_.point(k, ahead);
    if (over_seat(k)) p.y() += height_;
    return seat_.out(p);
  });
}

StandingLife::StandingLife(const Habits& habits) : walk_(habits.standing, every_stay(habits.standing)) {}

AheadPose StandingLife::next(const State& state, std::mt19937_64& random) {
  if (walk_.advance(random)) {
    place_ = stance_of(state.now().root, state.position[7], state.position[8]);
    height_ = state.position[15].y();
  }
  if (!ankle_) ankle_ = {state.position[7], state.position[8]};
  AheadPose out =
      gone_along(state, [&](int64_t k, int64_t ahead) { return place_.out(height_ * walk_.point(k, ahead)); });
  out.ankle = *ankle_;
  return out;
}

}  // namespace inhabit::interact
