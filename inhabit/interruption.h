#pragma once
#include <atomic>
#include <exception>
#include <functional>
#include <utility>

namespace inhabit {

// Long work looks now and then whether it is still wanted, so that who calls it can end it (Python's Ctrl-C) without
// asking for it in every signature.

/// What interruption_point() calls in this thread; empty: nothing.
inline std::function<void()>& interruption_check() {
  thread_local std::function<void()> check;
  return check;
}

/// While it lives, interruption points that this thread reaches call `check`, which throws to end the work.
class Interruptible {
 public:
  /// @param check called often, by this thread
  explicit Interruptible(std::function<void()> check)
      : before_(std::exchange(interruption_check(), std::move(check))) {}
  ~Interruptible() { interruption_check() = std::move(before_); }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

 private:
  std::function<void()> before_;
};

/// A place where work may end by an exception: between steps of a second or less, and in no parallel region that an
/// exception would leave.
inline void interruption_point() {
  if (const auto& check = interruption_check()) check();
}

/// What ends work that nobody waits for any more.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "interrupted"; }  ///< why it ended
};

/// A check for each thread of work that several do: once `over`, their interruption points end them; before, the
/// thread's own check is called.
inline std::function<void()> ends_once(const std::atomic<bool>& over) {
  return [&over, own = interruption_check()] {
    if (over.load(std::memory_order_relaxed)) throw Interrupted();
    if (own) own();
  };
}

}  // namespace inhabit
