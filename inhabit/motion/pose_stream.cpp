#include "inhabit/motion/pose_stream.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <utility>

#include "inhabit/body/skeleton.h"
#include "inhabit/error.h"
#include "inhabit/motion/plausible.h"

namespace inhabit {
namespace {

constexpr double kEarly = 1e-3;        // seconds: time stamps are rounded to milliseconds
constexpr double kLongestWindow = 60;  // seconds
constexpr int kMostPeople = 10000;

/// What is implausible() of the poses that are kept; nothing where joints were never seen.
std::string doubt_of(const PoseWindow& window) {
  constexpr double kRate = 10;
  try {
    const Clip clip = window.clip(kRate, static_cast<int64_t>(window.seconds() * kRate) + 1);
    return fmt::format("{}", fmt::join(implausible(clip, MotionSource::stream), "; "));
  } catch (const Error&) {  // said by who makes the result
    return "";
  }
}

}  // namespace

PoseStream::PoseStream(const PoseStreamOptions& options, double seconds, double least)
    : options_(options), seconds_(seconds), least_(least) {
  if (!(options.rate > 0)) throw Error("rate", "is not over 0");
  if (!(options.longest_gap > 0 && options.longest_gap <= kLongestWindow))
    throw Error("longest gap", "is not over 0 and at most 60 seconds");
  if (options.people < 1 || options.people > kMostPeople) throw Error("people", "are not 1 to 10000");
  if (!(options.forget >= 0)) throw Error("forget", "is not 0 seconds or more");
  if (!(seconds > 0 && seconds <= kLongestWindow)) throw Error("seconds", "are not over 0 and at most 60");
  const UsualSkeleton usual =
      usual_skeleton(options.names.empty() ? standard_joint_names() : options.names, options.parents, "names");
  skeleton_ = usual.skeleton;
  order_ = torch::tensor(std::vector<int64_t>(usual.order.begin(), usual.order.end()));
}

void PoseStream::make_room(double before, double time) {
  if (people_.size() < static_cast<size_t>(options_.people)) return;
  // Who is ahead was last seen before the clock jumped back, where the pose before this one is of this time too.
  const bool jumped = std::abs(before - time) <= options_.forget;
  std::erase_if(people_, [&](const auto& entry) {
    const double last = entry.second.window.last();
    return last < time - options_.forget || (jumped && last > time + options_.forget);
  });
  if (people_.size() >= static_cast<size_t>(options_.people))
    throw Error("person", "there are " + std::to_string(people_.size()) + " people already");
}

void PoseStream::push(const std::string& person, double time, const torch::Tensor& joints) {
  if (joints.dim() != 2 || joints.size(0) != this->joints() || joints.size(1) != 3)
    throw Error("joints", "are not (" + std::to_string(this->joints()) + ", 3)");
  const torch::Tensor ordered = joints.index_select(0, order_);
  auto found = people_.find(person);
  if (found == people_.end()) {
    // A window that has taken its first pose: who is refused is not remembered.
    PoseWindow window(skeleton_, seconds_, options_.longest_gap);
    window.push(time, ordered);
    make_room(std::exchange(clock_, time), time);
    found = people_.emplace(person, Person{std::move(window)}).first;
  } else {
    found->second.window.push(time, ordered);
    clock_ = time;
  }
  Person& p = found->second;
  const bool enough = p.window.seconds() > least_ - kEarly;
  if (!enough) p.running = p.due = false;
  if (!enough || p.due) return;
  if (!p.running) p.next = time, p.running = true;
  p.due = time > p.next - kEarly;
}

bool PoseStream::due(const std::string& person) const {
  const auto found = people_.find(person);
  return found != people_.end() && found->second.due;
}

std::vector<PoseStream::Due> PoseStream::take() {
  std::vector<Due> out;
  for (auto& [name, person] : people_) {
    if (!person.due) continue;
    person.due = false;
    const double time = person.window.last(), period = 1 / options_.rate;
    // The next on the grid of times that began with the first.
    if (period > 0) person.next += period * std::max(1.0, std::floor((time - person.next + kEarly) / period) + 1);
    out.push_back({name, time, &person.window, person.looked_at ? "" : doubt_of(person.window)});
    person.looked_at = true;
  }
  return out;
}

}  // namespace inhabit
