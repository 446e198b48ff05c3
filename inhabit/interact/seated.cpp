#include "inhabit/interact/seated.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/heading.h"
#include "inhabit/math/quantile.h"
#include "inhabit/motion/canonical.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;

/// A clip's pelvis, and what its frames are called.
struct SeatedView {
  const Clip& clip;
  torch::Tensor pelvis = clip.joints.select(1, 0).to(torch::kDouble).contiguous();
  torch::Tensor yaw = headings(clip.joints.to(torch::kDouble)).contiguous();

  int64_t frames() const { return clip.frames(); }
  double height(int64_t t) const { return pelvis.data_ptr<double>()[3 * t + 1]; }
  Vector3d place(int64_t t) const { return Eigen::Map<const Vector3d>(pelvis.data_ptr<double>() + 3 * t); }
  bool is(int64_t t, const std::string& name) const {
    if (!clip.action.defined() || t < 0 || t >= frames()) return false;
    const int64_t a = clip.action.data_ptr<int64_t>()[t];
    return a >= 0 && a < static_cast<int64_t>(clip.action_names.size()) &&
           clip.action_names[static_cast<size_t>(a)] == name;
  }
  /// The first or last frame (step -1 or 1) of a run of `name` that `from` is in or within half a second of; else -1.
  int64_t end_of_run(int64_t from, int64_t step, const std::string& name) const {
    int64_t t = from;
    const auto reach = static_cast<int64_t>(clip.rate / 2);
    while (!is(t, name) && std::abs(t - from) < reach) t += step;
    if (!is(t, name)) return -1;
    while (is(t + step, name)) t += step;
    return t;
  }
  /// The end of a fall (step -1, back in time) or rise (step 1) of the pelvis, three seconds away at most.
  int64_t end_of_climb(int64_t from, int64_t step) const {
    const auto reach = static_cast<int64_t>(3 * clip.rate);
    int64_t t = from;
    while (t + step >= 0 && t + step < frames() && std::abs(t + step - from) <= reach &&
           (height(t + step) > height(t) + 0.0005 || height(t) < height(from) + 0.02))
      t += step;
    return t;
  }
};

void measure(const SeatedView& view, Stay& stay) {
  std::array<std::vector<double>, 3> at;
  std::vector<double> change;
  const double* yaw = view.yaw.data_ptr<double>();
  for (int64_t t = stay.first; t <= stay.last; ++t) {
    for (size_t i = 0; i < 3; ++i) at[i].push_back(view.place(t)[static_cast<int>(i)]);
    change.push_back(wrapped(yaw[t] - yaw[stay.first]));
  }
  stay.rest = {median(at[0]), median(at[1]), median(at[2])};
  stay.heading = wrapped(yaw[stay.first] + median(change));
}

void find_transitions(const SeatedView& view, Stay& stay) {
  const double rate = view.clip.rate;
  const int64_t down = view.end_of_run(stay.first, -1, "sit_down");
  stay.down = std::min(stay.first, down >= 0 ? down : view.end_of_climb(stay.first, -1));
  const int64_t left = view.frames() - 1 - stay.last;
  stay.rises = left > static_cast<int64_t>(rate / 3);
  if (!stay.rises) {
    stay.rise = stay.risen = view.frames();
    return;
  }
  const int64_t up = view.end_of_run(stay.last, 1, "stand_up");
  stay.risen = up >= 0 ? up : view.end_of_climb(stay.last, 1);
  int64_t begin = stay.last;
  if (up >= 0)
    begin = view.end_of_run(up, -1, "stand_up");
  else  // the trunk comes forward before the pelvis leaves the seat
    begin = stay.last - static_cast<int64_t>(0.5 * rate);
  stay.rise = std::clamp(begin, stay.first, stay.risen);
}

}  // namespace

std::vector<Stay> stays_of(const Clip& clip) {
  std::vector<Stay> stays;
  if (!clip.contact.defined() || clip.frames() == 0) return stays;
  const SeatedView view{clip};
  const torch::Tensor touching = clip.contact.select(1, 0).to(torch::kFloat).contiguous();
  const float* on = touching.data_ptr<float>();
  std::vector<Stay> runs;
  for (int64_t t = 0; t < view.frames(); ++t) {
    if (on[t] < 0.5F) continue;
    const bool goes_on = !runs.empty() && static_cast<double>(t - runs.back().last) < clip.rate &&
                         (view.place(t) - view.place(runs.back().last)).norm() < 0.3;
    if (!goes_on) runs.push_back({t, t, t, 0, 0, false, Vector3d::Zero(), 0});
    runs.back().last = t;
  }
  for (Stay& run : runs) {
    if (static_cast<double>(run.last - run.first + 1) < clip.rate / 2) continue;
    measure(view, run);
    find_transitions(view, run);
    stays.push_back(run);
  }
  return stays;
}

}  // namespace inhabit::interact
