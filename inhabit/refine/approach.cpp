#include "inhabit/refine/approach.h"

#include <algorithm>
#include <utility>

#include "inhabit/scene/point_rows.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

// A person is within 1.3 m of the pelvis: frames farther from everything have nothing to ask.
constexpr double kBody = 1.3;
constexpr int64_t kStep = 8;          // frames
constexpr double kRounding = 0.0001;  // metres, of the query's floats

}  // namespace

Approach::Approach(const SceneQuery& solid, const std::vector<BodyBall>& balls, const Poses& poses, double reach)
    : solid_(solid), balls_(balls), poses_(poses), reach_(reach) {
  find_near();
  find_inside();
}

double Approach::wanted(size_t ball) const { return std::max(kDeepest, balls_[ball].radius + reach_); }

Vector3d Approach::place(int64_t frame, size_t ball) const {
  return place_of(balls_[ball].point, poses_[static_cast<size_t>(frame)]);
}

void Approach::ask(std::vector<BallPlace>& of) const {
  std::vector<Vector3d> places;
  places.reserve(of.size());
  for (const BallPlace& at : of) places.push_back(at.place);
  const ClosestPoints closest = solid_.closest(point_rows(places));
  for (size_t i = 0; i < of.size(); ++i) {
    of[i].surface = row_point(closest.points, i);
    of[i].normal = row_point(closest.normals, i);
    of[i].distance = closest.distances.data_ptr<float>()[i];
  }
}

void Approach::find_near() {
  std::vector<Vector3d> roots;
  for (const BonesPose& pose : poses_) roots.push_back(pose.positions[0]);
  const torch::Tensor far = solid_.closest(point_rows(roots)).distances;
  const auto frames = static_cast<int64_t>(poses_.size());
  std::vector<int64_t> close;
  for (int64_t t = 0; t < frames; ++t)
    if (far.data_ptr<float>()[t] <= kBody + reach_) close.push_back(t);
  // Every few frames first: they tell of those around them.
  const auto is_mark = [](size_t k) { return k % kStep == 0; };
  std::vector<BallPlace> marks, others;
  for (size_t k = 0; k < close.size(); ++k)
    for (size_t b = 0; is_mark(k) && b < balls_.size(); ++b) marks.push_back({close[k], b, place(close[k], b)});
  if (marks.empty()) return;
  ask(marks);
  for (size_t k = 0; k < close.size(); ++k)
    for (size_t b = 0; !is_mark(k) && b < balls_.size(); ++b) {
      const BallPlace& mark =
          marks[(k + kStep / 2) / kStep * balls_.size() < marks.size() ? (k + kStep / 2) / kStep * balls_.size() + b
                                                                       : k / kStep * balls_.size() + b];
      const Vector3d at = place(close[k], b);
      if (mark.distance - (at - mark.place).norm() < wanted(b) + kRounding) others.push_back({close[k], b, at});
    }
  ask(others);
  near = std::move(others);
  near.insert(near.end(), marks.begin(), marks.end());
  near.erase(
      std::remove_if(near.begin(), near.end(), [&](const BallPlace& at) { return at.distance >= wanted(at.ball); }),
      near.end());
  std::sort(near.begin(), near.end(), [](const BallPlace& a, const BallPlace& b) {
    return std::pair(a.frame, a.ball) < std::pair(b.frame, b.ball);
  });
}

void Approach::ask_inside(const std::vector<size_t>& of) {
  if (of.empty()) return;
  std::vector<Vector3d> places;
  places.reserve(of.size());
  for (const size_t i : of) places.push_back(near[i].place);
  const torch::Tensor answers = solid_.inside(point_rows(places));
  for (size_t k = 0; k < of.size(); ++k) inside[of[k]] = answers.data_ptr<bool>()[k] ? 1 : 0;
}

void Approach::find_inside() {
  constexpr size_t kNone = SIZE_MAX;
  const size_t count = near.size();
  inside.assign(count, 0);
  std::vector<size_t> last(balls_.size(), kNone), before(count, kNone), after(count, kNone), asked;
  for (size_t i = 0; i < count; ++i) {
    const size_t b = std::exchange(last[near[i].ball], i);
    if (b == kNone ||
        (near[i].place - near[b].place).norm() + kRounding >= std::max(near[i].distance, near[b].distance))
      continue;
    before[i] = b;
    after[b] = i;
  }
  std::vector<size_t> along(count, 0), from(count), to(count);  // marks at both sides
  const auto is_mark = [&](size_t i) { return along[i] % kStep == 0 || after[i] == kNone; };
  for (size_t i = 0; i < count; ++i) {
    if (before[i] != kNone) along[i] = along[before[i]] + 1;
    if (is_mark(i)) asked.push_back(i);
    from[i] = is_mark(i) ? i : from[before[i]];
  }
  for (size_t i = count; i-- > 0;) to[i] = is_mark(i) ? i : to[after[i]];
  ask_inside(asked);
  asked.clear();
  for (size_t i = 0; i < count; ++i) {
    if (is_mark(i)) continue;
    inside[i] = inside[from[i]];
    if (inside[from[i]] != inside[to[i]]) asked.push_back(i);
  }
  ask_inside(asked);
}

}  // namespace inhabit::refine
