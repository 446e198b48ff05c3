#include "inhabit/serve/server.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <thread>

#include "inhabit/error.h"
#include "inhabit/serve/http_session.h"
#include "inhabit/serve/live_page.h"
#include "inhabit/serve/live_session.h"

namespace inhabit::serve {

namespace asio = boost::asio;
using asio::ip::tcp;

struct Server::Impl {
  Hub hub;
  int threads;
  asio::io_context io;
  tcp::acceptor acceptor{io};
  asio::steady_timer grace{io};

  explicit Impl(int count) : threads(count), io(count) {}

  void listen(uint16_t port) {
    boost::system::error_code error;
    const tcp::endpoint here(asio::ip::address_v4::loopback(), port);
    acceptor.open(here.protocol(), error);
    if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor.bind(here, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error) throw Error("port " + std::to_string(port), "cannot be listened on: " + error.message());
  }

  void accept() {
    acceptor.async_accept(asio::make_strand(io), [this](boost::system::error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) {  // out of file descriptors: those that are open must end first
        grace.expires_after(std::chrono::milliseconds(100));
        grace.async_wait([this](boost::system::error_code e) {
          if (!e) accept();
        });
        return;
      }
      if (hub.sockets < hub.limits.sockets) {
        boost::system::error_code ignored;
        socket.set_option(tcp::no_delay(true), ignored);
        socket.set_option(asio::socket_base::send_buffer_size(hub.limits.send_buffer), ignored);
        std::make_shared<HttpSession>(std::move(socket), hub)->run();
      }
      accept();
    });
  }

  /// Pages hear of the end, and have half a second to close.
  void end() {
    boost::system::error_code ignored;
    acceptor.close(ignored);
    for (const auto& session : hub.sessions()) session->say_goodbye();
    wait_for_pages(std::chrono::steady_clock::now() + std::chrono::milliseconds(500));
  }

  void wait_for_pages(std::chrono::steady_clock::time_point latest) {
    if (hub.people == 0 || std::chrono::steady_clock::now() > latest) return io.stop();
    grace.expires_after(std::chrono::milliseconds(10));
    grace.async_wait([this, latest](boost::system::error_code) { wait_for_pages(latest); });
  }
};

Server::Server(std::shared_ptr<const World> world, const ServerOptions& options)
    : impl_(new Impl(options.threads > 0 ? options.threads
                                         : static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 4U)))) {
  Impl& p = *impl_;
  p.hub.world = std::move(world);
  p.hub.limits = options.limits;
  p.hub.page = live_page(*p.hub.world);
  p.listen(options.port);
  const std::string at = ":" + std::to_string(port());
  p.hub.hosts = {"127.0.0.1" + at, "localhost" + at};
  p.hub.policy =
      "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; connect-src "
      "'self' "
      "ws://127.0.0.1" +
      at + " ws://localhost" + at + "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
  p.accept();
}

Server::~Server() {
  impl_->io.stop();
  impl_->hub.workers.stop();
  impl_->hub.workers.join();
}

uint16_t Server::port() const { return impl_->acceptor.local_endpoint().port(); }
std::string Server::address() const { return "http://" + impl_->hub.hosts[0] + "/"; }

void Server::run(bool signals) {
  asio::signal_set caught(impl_->io);
  if (signals) {
    caught.add(SIGINT);
    caught.add(SIGTERM);
    caught.async_wait([this](boost::system::error_code error, int) {
      if (!error) impl_->end();
    });
  }
  const auto work = [this] {
    for (;;) {
      try {
        impl_->io.run();
        return;
      } catch (const std::exception&) {  // of one connection, which is gone with it
      }
    }
  };
  std::vector<std::thread> others;
  for (int i = 1; i < impl_->threads; ++i) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}

void Server::stop() {
  asio::post(impl_->io, [this] { impl_->end(); });
}

ServerStats Server::stats() const {
  const Hub& hub = impl_->hub;
  return {hub.people, hub.sockets, hub.frames, hub.dropped, hub.late};
}

}  // namespace inhabit::serve
