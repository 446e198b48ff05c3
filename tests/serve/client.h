#pragma once
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace inhabit::serve {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = asio::ip::tcp;

using Headers = std::map<std::string, std::string>;

inline std::string host_of(uint16_t port) { return "127.0.0.1:" + std::to_string(port); }

inline tcp::socket connected(asio::io_context& io, uint16_t port) {
  tcp::socket socket(io);
  socket.connect({asio::ip::address_v4::loopback(), port});
  return socket;
}

/// The answer to a request. @param headers over the usual ones; an empty value leaves that header out
inline http::response<http::string_body> ask(uint16_t port, const std::string& target, const Headers& headers = {},
                                             http::verb method = http::verb::get) {
  asio::io_context io;
  tcp::socket socket = connected(io, port);
  http::request<http::empty_body> request(method, target, 11);
  request.set(http::field::host, host_of(port));
  for (const auto& [name, value] : headers) {
    request.erase(name);
    if (!value.empty()) request.set(name, value);
  }
  http::write(socket, request);
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(64 << 20);
  if (method == http::verb::head) parser.skip(true);
  http::read(socket, buffer, parser);
  return parser.release();
}

/// Sends bytes as they are; all that comes back until the server closes.
inline std::string raw(uint16_t port, const std::string& bytes) {
  asio::io_context io;
  tcp::socket socket = connected(io, port);
  beast::error_code error;
  asio::write(socket, asio::buffer(bytes), error);
  std::string answer;
  asio::read(socket, asio::dynamic_buffer(answer), error);
  return answer;
}

/// A page without a browser.
class LiveClient {
 public:
  /// Throws beast::system_error where it is refused.
  explicit LiveClient(uint16_t port, const Headers& headers = {}, int receive_buffer = 0) : socket_(io_) {
    tcp::socket& plain = socket_.next_layer();
    plain.open(tcp::v4());
    if (receive_buffer > 0) plain.set_option(asio::socket_base::receive_buffer_size(receive_buffer));
    plain.connect({asio::ip::address_v4::loopback(), port});
    socket_.set_option(beast::websocket::stream_base::decorator([&](beast::websocket::request_type& request) {
      for (const auto& [name, value] : headers) request.set(name, value);
    }));
    http::response<http::string_body> answer;
    beast::error_code error;
    socket_.handshake(answer, host_of(port), "/live", error);
    status = answer.result_int();
    if (error) throw beast::system_error(error);
  }

  void send(const std::string& text) {
    socket_.text(true);
    socket_.write(asio::buffer(text));
  }
  void send(const nlohmann::json& message) { send(message.dump()); }
  void send_bytes(const std::string& bytes) {
    socket_.text(false);
    socket_.write(asio::buffer(bytes));
  }

  /// The next message, of either kind. Throws where the connection ended.
  std::string read() {
    beast::flat_buffer buffer;
    socket_.read(buffer);
    return beast::buffers_to_string(buffer.data());
  }
  bool got_text() const { return socket_.got_text(); }

  /// The next event of this kind.
  nlohmann::json event(const std::string& kind) {
    for (;;) {
      const std::string message = read();
      if (!got_text()) continue;
      const auto event = nlohmann::json::parse(message);
      if (event["event"] == kind) return event;
    }
  }
  /// The next pose.
  std::string pose() {
    for (;;) {
      std::string message = read();
      if (!got_text() && !message.empty() && message[0] == 1) return message;
    }
  }

  /// What the server closed the connection for.
  beast::websocket::close_reason closed() {
    try {
      for (;;) read();
    } catch (const beast::system_error&) {
      return socket_.reason();
    }
  }
  tcp::socket& plain() { return socket_.next_layer(); }

  unsigned status = 0;  ///< of the HTTP answer

 private:
  asio::io_context io_;
  beast::websocket::stream<tcp::socket> socket_;
};

/// A number in a message's bytes.
template <typename T>
T number_at(const std::string& bytes, size_t at) {
  T out;
  std::memcpy(&out, bytes.data() + at, sizeof out);
  return out;
}

}  // namespace inhabit::serve
