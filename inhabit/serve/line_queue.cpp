#include "inhabit/serve/line_queue.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>

#include "inhabit/error.h"

namespace inhabit::serve {
namespace {

constexpr size_t kMostBytes = 16U << 20, kMostLines = 65536;

}  // namespace

LineQueue::LineQueue(int file) : file_(file) {
  if (pipe(stop_) != 0) throw Error("input", "cannot be read: no pipe is left");
  reader_ = std::thread([this] { read(); });
}

LineQueue::~LineQueue() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  [[maybe_unused]] const ssize_t told = write(stop_[1], "", 1);
  reader_.join();
  close(stop_[0]);
  close(stop_[1]);
}

bool LineQueue::waiting() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return ended_ || !lines_.empty();
}

bool LineQueue::next(Line& line) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return ended_ || !lines_.empty(); });
  if (lines_.empty()) return false;
  line = std::move(lines_.front());
  lines_.pop_front();
  bytes_ -= line.text.size();
  changed_.notify_all();
  return true;
}

void LineQueue::put(Line line) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return stopping_ || (bytes_ < kMostBytes && lines_.size() < kMostLines); });
  bytes_ += line.text.size();
  lines_.push_back(std::move(line));
  changed_.notify_all();
}

void LineQueue::read() {
  std::array<char, 65536> buffer;
  Line line;
  const auto add = [&](std::string_view text) {
    if (line.text.size() + text.size() > kLongest) line = {"", true};
    if (!line.too_long) line.text += text;
  };
  for (;;) {
    std::array<pollfd, 2> files{pollfd{file_, POLLIN, 0}, pollfd{stop_[0], POLLIN, 0}};
    if (poll(files.data(), files.size(), -1) < 0) {
      if (errno == EINTR) continue;
      break;
    }
    if (files[1].revents != 0) break;
    const ssize_t got = ::read(file_, buffer.data(), buffer.size());
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (got <= 0) break;
    std::string_view text(buffer.data(), static_cast<size_t>(got));
    for (size_t end = 0; (end = text.find('\n')) != std::string_view::npos; text.remove_prefix(end + 1)) {
      add(text.substr(0, end));
      put(std::move(line));
      line = {};
    }
    add(text);
  }
  if (!line.text.empty() || line.too_long) put(std::move(line));
  const std::lock_guard<std::mutex> lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

}  // namespace inhabit::serve
