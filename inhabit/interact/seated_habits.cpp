#include "inhabit/interact/seated_habits.h"

#include <algorithm>

#include "inhabit/interact/features.h"
#include "inhabit/interact/sample.h"
#include "inhabit/math/random.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3f;

constexpr int64_t kPoints = 5;        // head, ankles, palms
constexpr int64_t kLeastSeated = 60;  // frames
constexpr int64_t kAlike = 16;        // stays that one is drawn from
constexpr float kHeightCounts = 2;    // a metre of the seat's height, against one of all numbers of its grid
constexpr float kPull = 0.1F;         // fraction of the distance to where the recorded person is, each second
constexpr int64_t kAhead = kSamples - 1 - kNow;

/// A stay of a recording: seated frames [first, end).
struct SeatedSpan {
  int64_t clip, first, end;
};

std::vector<SeatedSpan> spans_of(const Data& data) {
  std::vector<SeatedSpan> out;
  for (int64_t clip = 0; clip < data.clips(); ++clip) {
    const Recording& r = data.recording(clip);
    for (int64_t t = 0; t < r.size();) {
      int64_t end = t;
      while (end < r.size() && r.frames[static_cast<size_t>(end)].seated) ++end;
      if (end - t >= kLeastSeated) out.push_back({clip, t, end});
      t = end + 1;
    }
  }
  return out;
}

bool over_seat(int64_t point) { return point == 0 || point > 2; }

}  // namespace

SeatedHabits habits_of(const Data& data, int64_t count) {
  const std::vector<SeatedSpan> spans = spans_of(data);
  SeatedHabits out;
  std::vector<torch::Tensor> chairs;
  std::vector<float> heights, points;
  std::vector<int64_t> ends;
  for (const int64_t i : spread_indices(static_cast<int64_t>(spans.size()), count)) {
    const SeatedSpan& span = spans[static_cast<size_t>(i)];
    const Recording& r = data.recording(span.clip);
    const ChairGrid& chair = data.senses(span.clip).chair;
    chairs.push_back(torch::empty({data.config().chair_size()}));
    contact_condition(chair, chairs.back().data_ptr<float>());
    const float height = r.frames[static_cast<size_t>(span.first)].sample.goal.y();
    heights.push_back(height);
    for (int64_t t = span.first; t < span.end; t += kKeyStep) {
      const Recording::Frame& f = r.frames[static_cast<size_t>(t)];
      const std::array<Vector3f, kPoints> places = {f.position[15], f.position[7], f.position[8], f.sample.hand[0],
                                                    f.sample.hand[1]};
      for (int64_t k = 0; k < kPoints; ++k) {
        Vector3f p = chair.seat.in(places[static_cast<size_t>(k)]);
        if (over_seat(k)) p.y() -= height;
        points.insert(points.end(), p.data(), p.data() + 3);
      }
    }
    ends.push_back(static_cast<int64_t>(points.size()) / (3 * kPoints));
  }
  if (ends.empty()) return out;
  out.chairs = torch::stack(chairs);
  out.heights = torch::tensor(heights);
  out.ends = torch::tensor(ends);
  out.points = torch::tensor(points).view({-1, 3 * kPoints});
  return out;
}

SeatedLife::SeatedLife(const SeatedHabits& habits, const ChairGrid& chair, double seat_height)
    : habits_(habits), seat_(chair.seat), height_(static_cast<float>(seat_height)) {
  torch::Tensor own = torch::empty({habits.chairs.size(1)});
  contact_condition(chair, own.data_ptr<float>());
  const torch::Tensor order =
      ((habits.chairs - own).abs().mean(1) + kHeightCounts * (habits.heights - height_).abs()).argsort().contiguous();
  const int64_t* first = order.data_ptr<int64_t>();
  alike_.assign(first, first + std::min<int64_t>(kAlike, order.size(0)));
}

AheadPose SeatedLife::next(const State& state, std::mt19937_64& random) {
  const int64_t* ends = habits_.ends.data_ptr<int64_t>();
  const auto rows = [&] { return ends[stay_] - (stay_ > 0 ? ends[stay_ - 1] : 0); };
  if (stay_ < 0 || passed_ + kAhead >= (rows() - 1) * kKeyStep) {
    stay_ = alike_[static_cast<size_t>(uniform_int(random, 0, static_cast<int>(alike_.size()) - 1))];
    passed_ = 0;
  }
  const int64_t begin = ends[stay_] - rows();
  const float* points = habits_.points.data_ptr<float>();
  const auto place = [&](int64_t frame, int64_t k) {
    const int64_t last = ends[stay_] - 1, row = std::min(begin + frame / kKeyStep, last),
                  after = std::min(row + 1, last);
    const float part = static_cast<float>(frame % kKeyStep) / kKeyStep;
    const Eigen::Map<const Vector3f> a(points + (row * kPoints + k) * 3), b(points + (after * kPoints + k) * 3);
    Vector3f p = (1 - part) * a + part * b;
    if (over_seat(k)) p.y() += height_;
    return seat_.out(p);
  };
  const auto goal = [&](int64_t k, const Vector3f& now) -> Vector3f {
    const Vector3f then = place(passed_ + kAhead, k);
    return now + (1 - kPull) * (then - place(passed_, k)) + kPull * (then - now);
  };
  const AheadPose out = {true,
                         goal(0, state.position[15]),
                         {goal(1, state.position[7]), goal(2, state.position[8])},
                         {goal(3, state.now().hand[0]), goal(4, state.now().hand[1])},
                         {true, true}};
  ++passed_;
  return out;
}

}  // namespace inhabit::interact
