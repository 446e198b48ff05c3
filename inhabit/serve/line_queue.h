#pragma once
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <string>
#include <thread>

namespace inhabit::serve {

/// A line that came in.
struct Line {
  std::string text;       ///< without its end
  bool too_long = false;  ///< over LineQueue::kLongest bytes: its text was not kept
};

/// Reads lines of a file or pipe on a thread of its own, so that who works on them knows whether more are waiting.
/// Holds 16 MiB at most; who writes waits then.
class LineQueue {
 public:
  static constexpr size_t kLongest = 1U << 20;  ///< bytes of a line

  /// @param file descriptor that is read; it stays open
  explicit LineQueue(int file);
  ~LineQueue();
  LineQueue(const LineQueue&) = delete;
  LineQueue& operator=(const LineQueue&) = delete;

  /// Whether a line (or the end) is there already.
  bool waiting() const;
  /// The next line, once it is there; false at the end.
  bool next(Line& line);

 private:
  void read();
  void put(Line line);

  int file_;
  int stop_[2] = {-1, -1};  // a pipe that ends the thread
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Line> lines_;
  size_t bytes_ = 0;
  bool ended_ = false, stopping_ = false;
  std::thread reader_;
};

}  // namespace inhabit::serve
