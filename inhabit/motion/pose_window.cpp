#include "inhabit/motion/pose_window.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/math/heading.h"
#include "inhabit/motion/landmarks.h"

namespace inhabit {
namespace {

using Eigen::Vector3f;

constexpr double kMostRate = 240;     // poses a second that are kept
constexpr double kMargin = 0.3;       // seconds kept beyond what is asked for, for the cubic's ends
constexpr double kSmooth = 0.25;      // seconds: a longer gap is crossed straight
constexpr double kUneven = 5;         // neighbouring gaps that differ by more say nothing about the velocity
constexpr double kSame = 1e-6;        // seconds: the same time
constexpr double kRounded = 1e-3;     // seconds: time stamps may be rounded to milliseconds
constexpr double kFarthest = 1e4;     // metres
constexpr double kLatestTime = 1e11;  // seconds: doubles tell apart what is 15 microseconds apart
constexpr float kUnknown = 1e-9F;     // metres: an offset of zero

Vector3f rotated_by_yaw(const Vector3f& p, double yaw) {
  const auto c = static_cast<float>(std::cos(yaw)), s = static_cast<float>(std::sin(yaw));
  return {c * p.x() + s * p.z(), p.y(), c * p.z() - s * p.x()};
}

bool seen(const Vector3f& p) { return p.allFinite(); }

/// A joint's places at the times it was seen.
struct Track {
  std::vector<double> times;
  std::vector<Vector3f> places;

  /// Slope at sample i, from the parabola through it and its neighbours; along the segment to `other` where one is
  /// missing or much farther away.
  Vector3f slope(size_t i, size_t other) const {
    const auto chord = [&](size_t a, size_t b) -> Vector3f {
      return (places[b] - places[a]) / static_cast<float>(times[b] - times[a]);
    };
    const size_t n = times.size();
    const Vector3f along = chord(std::min(i, other), std::max(i, other));
    if (n < 3) return along;
    const size_t middle = std::clamp<size_t>(i, 1, n - 2);
    const double before = times[middle] - times[middle - 1], after = times[middle + 1] - times[middle];
    if (std::max(before, after) > kUneven * std::min(before, after)) return along;
    const Vector3f a = chord(middle - 1, middle), b = chord(middle, middle + 1);
    const Vector3f bend = (b - a) / static_cast<float>(before + after);
    if (i < middle) return a - bend * static_cast<float>(before);
    if (i > middle) return b + bend * static_cast<float>(after);
    return a + bend * static_cast<float>(before);
  }

  /// The place at a time between samples i and i + 1.
  Vector3f between(size_t i, double time) const {
    if (i + 1 >= times.size() || std::abs(time - times[i]) <= kSame) return places[i];
    if (std::abs(times[i + 1] - time) <= kSame) return places[i + 1];
    const double gap = times[i + 1] - times[i];
    const auto u = static_cast<float>((time - times[i]) / gap), h = static_cast<float>(gap);
    const Vector3f change = places[i + 1] - places[i];
    if (gap > kSmooth) return places[i] + u * change;
    const Vector3f from = h * slope(i, i + 1), to = h * slope(i + 1, i);
    return places[i] + u * (from + u * (3 * change - 2 * from - to + u * (from + to - 2 * change)));
  }
};

/// By one pair of joints, on the ground; false where that is no direction. Not headings(): of hips and shoulders that
/// are seen now and then, one pair must do, and a sum would jump as the other comes and goes.
bool heading_from(const Vector3f& left, const Vector3f& right, double& heading) {
  const Vector3f across = left - right;
  if (!seen(across) || std::hypot(across.x(), across.z()) < 0.02F) return false;
  heading = heading_of_left(across.x(), across.z());
  return true;
}

}  // namespace

PoseWindow::PoseWindow(const Skeleton& skeleton, double seconds, double longest_gap)
    : skeleton_(skeleton), kept_(seconds + kMargin), longest_gap_(longest_gap) {
  const Landmarks marks = find_landmarks(skeleton, "skeleton");
  hips_ = marks.hip;
  pairs_ = {marks.hip, marks.shoulder};
  const auto joints = static_cast<size_t>(skeleton.size());
  ring_.assign(static_cast<size_t>(std::ceil(kept_ * kMostRate)) + 3, Pose{0, std::vector<Vector3f>(joints)});
  const torch::Tensor offsets = skeleton.offsets.to(torch::kFloat32).contiguous();
  for (size_t j = 0; j < joints; ++j) from_parent_.emplace_back(offsets.data_ptr<float>() + 3 * j);
  root_from_hips_ = -0.5F * (from_parent_[static_cast<size_t>(hips_[0])] + from_parent_[static_cast<size_t>(hips_[1])]);
}

void PoseWindow::push(double time, const torch::Tensor& joints) {
  const auto size = static_cast<int64_t>(skeleton_.size());
  if (joints.sizes() != torch::IntArrayRef({size, 3}))
    throw Error("joints", "are not (" + std::to_string(size) + ", 3)");
  if (!(std::abs(time) < kLatestTime)) throw Error("time", "is no number of seconds below 1e11");
  const bool back = count_ > 0 && time < last() - kept_;
  if (count_ > 0 && time <= last() && !back) throw Error("time", "is not after the one before");
  const torch::Tensor places = joints.to(torch::kCPU, torch::kFloat32).contiguous();
  const auto place = [&](int j) { return Vector3f(places.data_ptr<float>() + 3 * j); };
  for (int j = 0; j < size; ++j)
    if (seen(place(j)) && !(place(j).cwiseAbs().maxCoeff() <= kFarthest))
      throw Error("joints", skeleton_.names[static_cast<size_t>(j)] + " is over 10 km from the origin");
  const bool hips = seen(place(hips_[0])) && seen(place(hips_[1]));
  if (!seen(place(0)) && !hips) throw Error("joints", "neither " + skeleton_.names[0] + " nor both hips are seen");

  if (back || (count_ > 0 && time - last() > longest_gap_)) begin_ = count_ = 0;
  while (count_ > 2 && time - at(1).time > kept_) begin_ = (begin_ + 1) % ring_.size(), --count_;
  const bool replaces = count_ > 1 && last() - at(count_ - 2).time < 1 / kMostRate - kSame;
  if (!replaces && ++count_ > ring_.size()) begin_ = (begin_ + 1) % ring_.size(), --count_;
  Pose& pose = at(count_ - 1);
  pose.time = time;
  for (int j = 0; j < size; ++j) pose.joints[static_cast<size_t>(j)] = place(j);
  remember(pose);
  if (!seen(pose.joints[0]))
    pose.joints[0] = 0.5F * (place(hips_[0]) + place(hips_[1])) + rotated_by_yaw(root_from_hips_, heading_);
}

void PoseWindow::remember(const Pose& pose) {
  const auto place = [&](int j) { return pose.joints[static_cast<size_t>(j)]; };
  if (!heading_from(place(hips_[0]), place(hips_[1]), heading_) &&
      !heading_from(place(pairs_[1][0]), place(pairs_[1][1]), heading_))
    return;
  for (int j = 1; j < skeleton_.size(); ++j) {
    const Vector3f offset = place(j) - place(skeleton_.parents[static_cast<size_t>(j)]);
    if (seen(offset)) from_parent_[static_cast<size_t>(j)] = rotated_by_yaw(offset, -heading_);
  }
  const Vector3f from_hips = place(0) - 0.5F * (place(hips_[0]) + place(hips_[1]));
  if (seen(from_hips)) root_from_hips_ = rotated_by_yaw(from_hips, -heading_);
}

Clip PoseWindow::clip(double rate, int64_t frames) const {
  if (count_ == 0) throw Error("person", "was not seen");
  const auto there = static_cast<int64_t>(std::floor((seconds() + kRounded) * rate)) + 1;
  const int64_t T = std::max<int64_t>(1, std::min(frames, there)), J = skeleton_.size();
  const auto time_of = [&](int64_t t) { return std::max(first(), last() - static_cast<double>(T - 1 - t) / rate); };

  std::vector<Vector3f> out(static_cast<size_t>(T * J), Vector3f::Constant(NAN));
  const auto place = [&](int64_t t, int64_t j) -> Vector3f& { return out[static_cast<size_t>(t * J + j)]; };
  for (int64_t j = 0; j < J; ++j) {
    Track track;
    for (size_t i = 0; i < count_; ++i) {
      const Vector3f& p = at(i).joints[static_cast<size_t>(j)];
      if (seen(p)) track.times.push_back(at(i).time), track.places.push_back(p);
    }
    size_t i = 0;
    for (int64_t t = 0; t < T && !track.times.empty(); ++t) {
      const double time = time_of(t);
      if (time < track.times.front() - kSame || time > track.times.back() + kSame) continue;
      while (i + 1 < track.times.size() && track.times[i + 1] <= time) ++i;
      place(t, j) = track.between(i, time);
    }
  }

  std::vector<double> headings(static_cast<size_t>(T), NAN);
  for (int64_t t = 0; t < T; ++t)
    for (const auto& [left, right] : pairs_)
      if (heading_from(place(t, left), place(t, right), headings[static_cast<size_t>(t)])) break;
  double near = heading_;
  for (auto h = headings.rbegin(); h != headings.rend(); ++h) near = *h = std::isnan(*h) ? near : *h;

  for (int64_t j = 1; j < J; ++j) {
    const int64_t parent = skeleton_.parents[static_cast<size_t>(j)];
    const auto follow = [&](int64_t t, const Vector3f& offset, double heading) {
      place(t, j) = place(t, parent) + rotated_by_yaw(offset, headings[static_cast<size_t>(t)] - heading);
    };
    int64_t first = 0, last_seen = T - 1;
    while (first < T && !seen(place(first, j))) ++first;
    while (last_seen >= 0 && !seen(place(last_seen, j))) --last_seen;
    if (first == T && from_parent_[static_cast<size_t>(j)].norm() < kUnknown)
      throw Error("joints", skeleton_.names[static_cast<size_t>(j)] + " was never seen");
    for (int64_t t = 0; t < T; ++t) {
      if (t >= first && t <= last_seen) continue;
      if (first == T) {
        follow(t, from_parent_[static_cast<size_t>(j)], 0);
        continue;
      }
      const int64_t known = t < first ? first : last_seen;
      follow(t, place(known, j) - place(known, parent), headings[static_cast<size_t>(known)]);
    }
  }

  Clip clip;
  clip.skeleton = skeleton_;
  clip.rate = rate;
  clip.joints = torch::empty({T, J, 3});
  std::copy_n(out.front().data(), 3 * T * J, clip.joints.data_ptr<float>());
  return clip;
}

}  // namespace inhabit
