#pragma once
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <memory>

#include "inhabit/serve/character.h"
#include "inhabit/serve/hub.h"

namespace inhabit::serve {

/// One page's connection to its person: messages in, poses out, 30 a second. Everything happens on the strand of its
/// socket.
class LiveSession : public std::enable_shared_from_this<LiveSession> {
 public:
  /// @param counted keeps count of the socket and of the person, until the session is gone.
  LiveSession(boost::beast::tcp_stream stream, Hub& hub, std::shared_ptr<void> counted);
  ~LiveSession();

  void run(const boost::beast::http::request<boost::beast::http::empty_body>& upgrade);
  /// Ends it politely. From any thread.
  void say_goodbye();

 private:
  using Clock = std::chrono::steady_clock;
  enum Kind { kForecast, kFutures, kTarget, kKinds };

  void begin();
  void read();
  void on_message();
  bool too_many_messages();
  void obey(const Message& message);
  void end();

  void step();
  void record_frame();
  void watch();
  void look(Kind kind);
  void take(const Take& take);
  void record(bool on);

  void tell(const std::string& json);
  void say(const std::string& text, bool error);
  void tell_contacts();
  void paint(Kind kind, const std::vector<Ghost>& ghosts);
  void write();
  void close(boost::beast::websocket::close_code code, const std::string& reason);

  /// Computes on the hub's thread, then goes on here with what came out; errors are said. False where too much waits.
  template <typename Compute, typename Then>
  bool compute(Compute compute, Then then);

  Hub& hub_;
  std::shared_ptr<void> counted_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  boost::beast::flat_buffer in_;
  boost::asio::steady_timer timer_;
  Clock::time_point next_step_, write_began_, allowance_since_;
  double allowance_ = 0;  // messages that may come at once
  bool ended_ = false, closing_ = false, writing_ = false;

  std::unique_ptr<Character> character_;
  uint32_t number_ = 0;  // of the last message
  Contacts told_contacts_;

  std::string sent_;              // what is being written
  std::deque<std::string> told_;  // text that waits
  std::string pose_;              // the newest pose that waits; empty: none
  std::array<std::string, kKinds> ghosts_;

  std::array<bool, 2> looking_{}, computing_{};
  std::array<uint32_t, 2> looked_{};  // frame of the last preview
  uint32_t takes_ = 0;
  bool aiming_ = false, filling_ = false;  // a pose is painted; is being moved to

  bool recording_ = false;
  std::vector<Frame> recorded_;
  std::string token_;
};

}  // namespace inhabit::serve
