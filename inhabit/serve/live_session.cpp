#include "inhabit/serve/live_session.h"

#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/serve/live_page.h"
#include "inhabit/serve/poses.h"
#include "inhabit/serve/previews.h"

namespace inhabit::serve {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using nlohmann::json;

constexpr std::chrono::microseconds kPeriod{33333};
constexpr uint32_t kLookEvery = 12;  // frames between two previews
constexpr double kObserved = 2.2;    // seconds that previews are given

json point(const std::optional<Eigen::Vector3d>& p) { return p ? json{p->x(), p->y(), p->z()} : json(); }

}  // namespace

LiveSession::LiveSession(beast::tcp_stream stream, Hub& hub, std::shared_ptr<void> counted)
    : hub_(hub), counted_(std::move(counted)), socket_(std::move(stream)), timer_(socket_.get_executor()) {}

LiveSession::~LiveSession() {
  hub_.leave(this);
  hub_.forget(token_);
}

void LiveSession::run(const beast::http::request<beast::http::empty_body>& upgrade) {
  hub_.join(this, weak_from_this());
  beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has its own
  websocket::stream_base::timeout timeouts;
  timeouts.handshake_timeout = std::chrono::seconds(10);
  timeouts.idle_timeout = hub_.limits.idle;
  timeouts.keep_alive_pings = true;
  socket_.set_option(timeouts);
  socket_.read_message_max(hub_.limits.message);
  socket_.async_accept(upgrade, [self = shared_from_this()](beast::error_code error) {
    if (!error) self->begin();
  });
}

void LiveSession::begin() {
  character_ = std::make_unique<Character>(hub_.world);
  allowance_ = 2.0 * hub_.limits.messages;
  allowance_since_ = next_step_ = Clock::now();
  tell(greeting(*hub_.world, hub_.limits.recorded));
  read();
  step();
}

void LiveSession::end() {
  ended_ = true;
  timer_.cancel();
}

void LiveSession::say_goodbye() {
  boost::asio::post(socket_.get_executor(),
                    [self = shared_from_this()] { self->close(websocket::close_code::going_away, "the server ends"); });
}

void LiveSession::close(websocket::close_code code, const std::string& reason) {
  if (closing_ || ended_) return;
  closing_ = true;
  timer_.cancel();
  socket_.async_close({code, reason}, [self = shared_from_this()](beast::error_code) { self->end(); });
}

void LiveSession::read() {
  socket_.async_read(in_, [self = shared_from_this()](beast::error_code error, size_t) {
    if (error || self->closing_) return self->end();
    self->on_message();
    if (!self->closing_) self->read();
  });
}

bool LiveSession::too_many_messages() {
  const Clock::time_point now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - allowance_since_).count();
  allowance_since_ = now;
  allowance_ = std::min(2.0 * hub_.limits.messages, allowance_ + seconds * hub_.limits.messages) - 1;
  return allowance_ < 0;
}

void LiveSession::on_message() {
  const std::string text = beast::buffers_to_string(in_.data());
  in_.consume(in_.size());
  if (too_many_messages()) return close(websocket::close_code::policy_error, "too many messages");
  try {
    if (!socket_.got_text()) throw Error("message", "is no text");
    const Message message = parse_message(text);
    number_ = message.number;
    obey(message);
  } catch (const Error& e) {
    say(e.what(), true);
  } catch (const std::exception& e) {
    say(std::string("unexpected: ") + e.what(), true);
  }
  tell_contacts();
}

void LiveSession::obey(const Message& message) {
  struct Do {
    LiveSession& session;
    void operator()(const Walk& o) const { session.character_->walk(o.to); }
    void operator()(const Sit& o) const { session.character_->sit(o.chair); }
    void operator()(const Touch& o) const { session.character_->touch(o); }
    void operator()(const Draw&) const { session.character_->draw(); }
    void operator()(const Stand&) const { session.character_->stand(); }
    void operator()(const Restart&) const { session.character_->restart(); }
    void operator()(const Record& o) const { session.record(o.on); }
    void operator()(const Look& o) const {
      const Kind kind = o.what == Preview::forecast ? kForecast : kFutures;
      if (o.on && !(kind == kForecast ? session.hub_.world->forecaster.has_value()
                                      : session.hub_.world->anticipator.has_value()))
        throw Error(kind == kForecast ? "forecast" : "futures", "no model of it is here");
      session.looking_[kind] = o.on;
      if (!o.on) session.paint(kind, {});
    }
    void operator()(const Take& o) const { session.take(o); }
  };
  // Whatever else the person is told ends the motion to a pose.
  const bool moves = !std::holds_alternative<Record>(message.order) && !std::holds_alternative<Look>(message.order);
  if (moves) {
    ++takes_;
    filling_ = false;
  }
  std::visit(Do{*this}, message.order);
  if (moves && aiming_ && !filling_) {
    aiming_ = false;
    paint(kTarget, {});
  }
}

template <typename Compute, typename Then>
bool LiveSession::compute(Compute compute, Then then) {
  // The session may be gone when the job's turn comes, and is not kept for it.
  const bool posted = hub_.post([weak = weak_from_this(), world = hub_.world, compute = std::move(compute), then] {
    decltype(compute(*world)) result;
    std::string error;
    if (weak.expired()) return;
    try {
      result = compute(*world);
    } catch (const std::exception& e) {
      error = e.what();
    }
    const auto self = weak.lock();
    if (!self) return;
    boost::asio::post(self->socket_.get_executor(),
                      [self, then, result = std::move(result), error = error.substr(0, error.find('\n'))] {
                        if (!error.empty()) self->say(error, true);
                        then(*self, error.empty(), result);
                      });
  });
  if (!posted) say("the server is busy: try again in a moment", true);
  return posted;
}

void LiveSession::take(const Take& take) {
  if (!hub_.world->inbetweener) throw Error("pose", "no model of in-betweening is here");
  const Frame target = pose_at(*hub_.world, take.pose, take.at, take.heading);
  aiming_ = true;
  paint(kTarget, {{0, 0, target}});
  filling_ =
      compute([from = character_->frame(), target](const World& world) { return motion_to(world, from, target); },
              [takes = takes_](LiveSession& self, bool good, const Clip& motion) {
                if (takes != self.takes_) return;  // told otherwise meanwhile
                if (good) return self.character_->play(motion);
                self.filling_ = self.aiming_ = false;
                self.paint(kTarget, {});
              });
}

void LiveSession::look(Kind kind) {
  const Status status = character_->status();
  if (!looking_[kind] || computing_[kind] || status.index - looked_[kind] < kLookEvery) return;
  looked_[kind] = status.index;
  computing_[kind] = compute(
      [kind, recent = character_->recent(kObserved)](const World& world) {
        return kind == kForecast ? forecast_ghosts(world, recent) : future_ghosts(world, recent, 1);
      },
      [kind](LiveSession& self, bool good, const std::vector<Ghost>& ghosts) {
        self.computing_[kind] = false;
        if (!good) self.looking_[kind] = false;
        if (self.looking_[kind]) self.paint(kind, ghosts);
      });
}

void LiveSession::record(bool on) {
  if (on) {
    hub_.forget(token_);
    token_.clear();
    recorded_.clear();
    recorded_.shrink_to_fit();
    recording_ = true;
    return;
  }
  if (!recording_) throw Error("record", "nothing is recorded");
  recording_ = false;
  const size_t frames = recorded_.size();
  if (frames == 0) throw Error("record", "no frame was recorded");
  token_ = hub_.keep(std::make_shared<const std::vector<Frame>>(std::move(recorded_)));
  recorded_ = {};
  tell(json{{"event", "recorded"}, {"frames", frames}, {"file", "recordings/" + token_}}.dump());
}

void LiveSession::record_frame() {
  if (!recording_) return;
  recorded_.push_back(character_->frame());
  if (static_cast<int>(recorded_.size()) < hub_.limits.recorded) return;
  record(false);
  say("the recording ended: it is as long as one may be", false);
}

void LiveSession::step() {
  if (ended_ || closing_) return;
  try {
    character_->step();
    record_frame();
    look(kForecast);
    look(kFutures);
    if (filling_ && aiming_ && character_->status().filling) filling_ = false;
    if (aiming_ && !filling_ && !character_->playing()) {
      aiming_ = false;
      paint(kTarget, {});
    }
  } catch (const std::exception& e) {
    say(std::string("unexpected: ") + e.what(), true);
  }
  tell_contacts();
  if (!pose_.empty()) ++hub_.dropped;
  Status status = character_->status();
  status.recording = recording_;
  status.number = number_;
  pose_ = pose_bytes(character_->frame(), status);
  write();
  watch();
  next_step_ += kPeriod;
  if (const Clock::time_point now = Clock::now(); now > next_step_ + kPeriod) {
    hub_.late += (now - next_step_) / kPeriod;
    next_step_ = now;  // people slow down where there is no time for them
  }
  timer_.expires_at(next_step_);
  timer_.async_wait([self = shared_from_this()](beast::error_code error) {
    if (!error) self->step();
  });
}

/// A page that has taken nothing for long is dropped.
void LiveSession::watch() {
  const bool stuck = writing_ && Clock::now() - write_began_ > hub_.limits.stuck;
  if (!stuck && static_cast<int>(told_.size()) <= hub_.limits.told) return;
  ended_ = true;
  beast::error_code ignored;
  beast::get_lowest_layer(socket_).socket().close(ignored);
}

void LiveSession::tell(const std::string& text) {
  told_.push_back(text);
  write();
}

void LiveSession::say(const std::string& text, bool error) {
  const json out = {{"event", "said"}, {"text", text.substr(0, 300)}, {"error", error}};
  tell(out.dump(-1, ' ', false, json::error_handler_t::replace));
}

void LiveSession::tell_contacts() {
  const Contacts& now = character_->contacts();
  if (now.chair == told_contacts_.chair && now.at == told_contacts_.at) return;
  told_contacts_ = now;
  tell(json{{"event", "contacts"}, {"chair", now.chair}, {"left", point(now.at[0])}, {"right", point(now.at[1])}}.dump(
      -1, ' ', false, json::error_handler_t::replace));
}

void LiveSession::paint(Kind kind, const std::vector<Ghost>& ghosts) {
  ghosts_[kind] = ghost_bytes(kind, ghosts);
  write();
}

void LiveSession::write() {
  if (writing_ || ended_ || closing_) return;
  bool text = false;
  if (!told_.empty()) {
    sent_ = std::move(told_.front());
    told_.pop_front();
    text = true;
  } else {
    std::string* waiting = &pose_;
    for (std::string& ghosts : ghosts_)
      if (waiting->empty()) waiting = &ghosts;
    if (waiting->empty()) return;
    if (waiting == &pose_) ++hub_.frames;
    sent_ = std::move(*waiting);
    waiting->clear();
  }
  writing_ = true;
  write_began_ = Clock::now();
  socket_.text(text);
  socket_.async_write(boost::asio::buffer(sent_), [self = shared_from_this()](beast::error_code error, size_t) {
    self->writing_ = false;
    if (error) return self->end();
    self->write();
  });
}

}  // namespace inhabit::serve
