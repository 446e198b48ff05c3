#pragma once
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>

#include "inhabit/serve/hub.h"

namespace inhabit::serve {

/// A connection that asks for the page, for a recording's file, or to become a LiveSession.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(boost::asio::ip::tcp::socket socket, Hub& hub);
  void run();

 private:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;
  using Response = boost::beast::http::response<boost::beast::http::span_body<const char>>;

  void read();
  void on_request();
  void upgrade();
  void download(const std::string& token, const std::string& extension);
  void refuse(boost::beast::http::status status, const std::string& reason);
  /// @param held keeps what `body` points to.
  void respond(boost::beast::http::status status, const char* type, std::shared_ptr<const std::string> body,
               const std::string& file = "");

  Hub& hub_;
  std::shared_ptr<void> counted_;
  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer in_{16384};
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  Request request_;
  std::shared_ptr<Response> response_;
  std::shared_ptr<const std::string> body_;
};

}  // namespace inhabit::serve
