#pragma once

namespace inhabit {

/// How the learning rate goes over the steps of a training: up along a line, down along a cosine. The peak is apart.
struct RateSchedule {
  double warmup = 0.05;  ///< of the steps, in which the rate rises from 0
  double floor = 0.02;   ///< of the peak, which the cosine ends at

  bool operator==(const RateSchedule&) const = default;  ///< compares both
};

/// What a configuration checks: warmup in [0, 1], floor in [0, 1].
template <class Check>
void check_schedule(const Check& check, const RateSchedule& schedule) {
  check.within("training.warmup", schedule.warmup, 0, 1);
  check.within("training.rate_floor", schedule.floor, 0, 1);
}

}  // namespace inhabit
