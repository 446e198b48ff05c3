#include "inhabit/serve/http_session.h"

#include <boost/beast/websocket/rfc6455.hpp>

#include "inhabit/error.h"
#include "inhabit/serve/live_session.h"
#include "inhabit/serve/recording_file.h"

namespace inhabit::serve {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;

constexpr uint32_t kHeader = 8192;  // bytes
constexpr std::chrono::seconds kPatience{10};

/// Counts one of something while it lives.
std::shared_ptr<void> counted_in(std::atomic<int>& count) {
  ++count;
  return {&count, [](void* at) { --*static_cast<std::atomic<int>*>(at); }};
}

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

HttpSession::HttpSession(boost::asio::ip::tcp::socket socket, Hub& hub)
    : hub_(hub), counted_(counted_in(hub.sockets)), stream_(std::move(socket)) {}

void HttpSession::run() {
  boost::asio::post(stream_.get_executor(), [self = shared_from_this()] { self->read(); });
}

void HttpSession::read() {
  parser_.emplace();
  parser_->header_limit(kHeader);
  stream_.expires_after(kPatience);
  http::async_read(stream_, in_, *parser_, [self = shared_from_this()](beast::error_code error, size_t) {
    if (!error) {
      self->request_ = self->parser_->release();
      return self->on_request();
    }
    // What is no HTTP, or too long, or has a body.
    if (error.category() == http::make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message) {
      self->request_ = {};
      self->refuse(http::status::bad_request, "no request of this page");
    }
  });
}

void HttpSession::on_request() {
  // A page elsewhere whose name leads here (DNS rebinding) brings that name along; so does its script's origin.
  if (request_.count(http::field::host) != 1 || !hub_.is_host(view(request_[http::field::host])))
    return refuse(http::status::misdirected_request, "this server is called " + hub_.hosts[0]);
  if (const auto origins = request_.count(http::field::origin);
      origins > 1 || (origins == 1 && !hub_.is_origin(view(request_[http::field::origin]))))
    return refuse(http::status::forbidden, "other sites' pages are not served");
  std::string target(view(request_.target()));
  if (target == "/live") return upgrade();
  if (request_.method() != http::verb::get && request_.method() != http::verb::head)
    return refuse(http::status::method_not_allowed, "only GET is understood");
  if (target == "/") return respond(http::status::ok, "text/html; charset=utf-8", {&hub_.page, [](const void*) {}});
  constexpr std::string_view kRecordings = "/recordings/";
  const size_t dot = target.rfind('.');
  if (target.rfind(kRecordings, 0) == 0 && dot != std::string::npos) {
    const std::string extension = target.substr(dot + 1);
    if (extension == "bvh" || extension == "glb" || extension == "npz")
      return download(target.substr(kRecordings.size(), dot - kRecordings.size()), extension);
  }
  refuse(http::status::not_found, "there is no such page");
}

void HttpSession::upgrade() {
  if (!beast::websocket::is_upgrade(request_)) return refuse(http::status::upgrade_required, "this is for WebSockets");
  const std::shared_ptr<void> person = counted_in(hub_.people);
  if (hub_.people > hub_.limits.people)
    return refuse(http::status::service_unavailable,
                  "as many pages are connected as may be: " + std::to_string(hub_.limits.people));
  struct Both {
    std::shared_ptr<void> socket, person;
  };
  std::make_shared<LiveSession>(std::move(stream_), hub_, std::make_shared<Both>(Both{counted_, person}))
      ->run(request_);
}

void HttpSession::download(const std::string& token, const std::string& extension) {
  const Recording recording = hub_.recording(token);
  if (!recording) return refuse(http::status::not_found, "there is no such recording");
  stream_.expires_never();
  const bool posted = hub_.post([self = shared_from_this(), recording, extension] {
    auto body = std::make_shared<std::string>();
    bool good = true;
    try {
      *body = recording_file(*self->hub_.world, *recording, extension);
    } catch (const std::exception& e) {
      *body = e.what();
      good = false;
    }
    boost::asio::post(self->stream_.get_executor(), [self, body, good, extension] {
      if (!good) return self->refuse(http::status::internal_server_error, *body);
      self->respond(http::status::ok, "application/octet-stream", body, "inhabit." + extension);
    });
  });
  if (!posted) refuse(http::status::service_unavailable, "the server is busy: try again in a moment");
}

void HttpSession::refuse(http::status status, const std::string& reason) {
  request_.keep_alive(false);
  respond(status, "text/plain; charset=utf-8", std::make_shared<const std::string>(reason + "\n"));
}

void HttpSession::respond(http::status status, const char* type, std::shared_ptr<const std::string> body,
                          const std::string& file) {
  body_ = std::move(body);
  response_ = std::make_shared<Response>(status, 11);
  Response& r = *response_;
  r.set(http::field::content_type, type);
  r.set(http::field::cache_control, "no-store");
  r.set("X-Content-Type-Options", "nosniff");
  r.set("X-Frame-Options", "DENY");
  r.set("Cross-Origin-Resource-Policy", "same-origin");
  r.set("Referrer-Policy", "no-referrer");
  r.set("Content-Security-Policy", hub_.policy);
  if (!file.empty()) r.set(http::field::content_disposition, "attachment; filename=\"" + file + "\"");
  r.keep_alive(request_.keep_alive());
  r.content_length(body_->size());
  if (request_.method() != http::verb::head) r.body() = beast::span<const char>(body_->data(), body_->size());
  stream_.expires_after(3 * kPatience);
  const auto done = [self = shared_from_this()](beast::error_code error, size_t) {
    if (error) return;
    if (self->response_->need_eof()) {
      beast::error_code ignored;
      self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
      return;
    }
    self->read();
  };
  if (request_.method() == http::verb::head) {
    auto serializer = std::make_shared<http::response_serializer<http::span_body<const char>>>(r);
    http::async_write_header(stream_, *serializer,
                             [done, serializer](beast::error_code error, size_t n) { done(error, n); });
  } else {
    http::async_write(stream_, r, done);
  }
}

}  // namespace inhabit::serve
