#pragma once
#include <array>
#include <atomic>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "inhabit/serve/frames.h"
#include "inhabit/serve/server.h"

namespace inhabit::serve {

class LiveSession;
using Recording = std::shared_ptr<const std::vector<Frame>>;

/// What all connections of a server share. Safe to use from several threads.
struct Hub {
  std::shared_ptr<const World> world;
  Limits limits;
  std::string page, policy;          ///< HTML and its content security policy
  std::array<std::string, 2> hosts;  ///< that the server is called by: 127.0.0.1:PORT, localhost:PORT
  std::atomic<int> people{0}, sockets{0}, jobs{0};
  std::atomic<int64_t> frames{0}, dropped{0}, late{0};

  bool is_host(std::string_view name) const { return name == hosts[0] || name == hosts[1]; }
  bool is_origin(std::string_view origin) const {
    constexpr std::string_view kScheme = "http://";
    return origin.substr(0, kScheme.size()) == kScheme && is_host(origin.substr(kScheme.size()));
  }

  /// Runs `job` on the thread for what takes long. False where too many wait.
  bool post(std::function<void()> job) {
    if (++jobs > limits.jobs) {
      --jobs;
      return false;
    }
    boost::asio::post(workers, [this, job = std::move(job)] {
      job();
      --jobs;
    });
    return true;
  }

  /// Keeps a recording under a name that nobody guesses.
  std::string keep(Recording recording);
  Recording recording(const std::string& token);
  void forget(const std::string& token);

  void join(LiveSession* session, std::weak_ptr<LiveSession> weak);
  void leave(LiveSession* session);
  std::vector<std::shared_ptr<LiveSession>> sessions();

  boost::asio::thread_pool workers{1};

 private:
  std::mutex mutex_;
  std::map<std::string, Recording> recordings_;
  std::map<LiveSession*, std::weak_ptr<LiveSession>> sessions_;
};

}  // namespace inhabit::serve
