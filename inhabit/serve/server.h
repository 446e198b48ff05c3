#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "inhabit/serve/world.h"

namespace inhabit::serve {

/// What one server takes on at once. Memory is bounded by these (docs/live.md).
struct Limits {
  int people = 100;                        ///< pages connected to /live; more are refused with 503
  int sockets = 256;                       ///< connections of any kind; more are closed at once
  size_t message = 2048;                   ///< bytes of a message; a longer one ends the connection
  int messages = 120;                      ///< a second, over a few seconds; more end the connection
  int told = 64;                           ///< answers that wait for a slow page; more end the connection
  int recorded = 5400;                     ///< frames of a recording: three minutes
  int jobs = 32;                           ///< previews and files that wait to be made; more are refused
  int send_buffer = 65536;                 ///< bytes that the system keeps for a page that is slow
  std::chrono::milliseconds idle{20000};   ///< without any answer, pings among them: the page has vanished
  std::chrono::milliseconds stuck{10000};  ///< in which a page takes nothing: it is dropped
};

/// How a server runs.
struct ServerOptions {
  uint16_t port = 0;  ///< 0: a free one
  Limits limits;      ///< of what it takes on
  int threads = 0;    ///< 0: as many as cores, up to four
};

/// What a server has done so far.
struct ServerStats {
  int people = 0;       ///< connected now
  int sockets = 0;      ///< open now
  int64_t frames = 0;   ///< poses sent
  int64_t dropped = 0;  ///< poses left out for slow pages
  int64_t late = 0;     ///< steps left out for want of time
};

/// The live page: HTTP and a WebSocket on 127.0.0.1 (docs/live.md). Each page that connects has a person of its own.
///
///   Server server(make_world(scene, models), {});
///   server.run();   // until stop()
class Server {
 public:
  /// Listens from now on. Throws Error where the port cannot be had.
  Server(std::shared_ptr<const World> world, const ServerOptions& options);
  ~Server();

  uint16_t port() const;        ///< that it listens on
  std::string address() const;  ///< "http://127.0.0.1:8080/"

  /// Serves until stop() or, where `signals` is set, until the process is interrupted (SIGINT, SIGTERM).
  void run(bool signals = false);
  /// Says goodbye to all pages and ends run(). From any thread.
  void stop();
  ServerStats stats() const;  ///< from any thread

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::serve
