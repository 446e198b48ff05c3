// Protects the server against what comes over a socket: foreign names and origins, damaged, large and endless messages,
// pages that are slow, silent or gone, and too many of them. Whatever it is, the next page is served.
#include "inhabit/serve/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "client.h"
#include "inhabit/interact/contact_area.h"
#include "inhabit/io/files.h"
#include "refusal_of.h"
#include "small_world.h"
#include "temp_folder.h"

namespace inhabit::serve {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

/// A server that runs while this lives.
struct Running {
  Server server;
  std::thread thread;
  explicit Running(const Limits& limits = {})
      : server(small_world(), {0, limits, 2}), thread([this] { server.run(); }) {}
  ~Running() {
    server.stop();
    thread.join();
  }
  uint16_t port() const { return server.port(); }
};

/// Whether something comes true within a time.
template <typename True>
bool soon(const True& is_true, double seconds = 20) {
  for (const auto end = Clock::now() + std::chrono::duration<double>(seconds); !is_true();) {
    if (Clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

double resident_mb() {
  std::ifstream status("/proc/self/statm");
  double size = 0, resident = 0;
  status >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

void expect_alive(uint16_t port) {
  LiveClient client(port);
  EXPECT_EQ(client.event("hello")["chairs"].size(), 1);
  EXPECT_EQ(client.pose().size(), 208);
}

TEST(Server, GivesThePageAndNothingElse) {
  const Running running;
  const auto page = ask(running.port(), "/");
  EXPECT_EQ(page.result_int(), 200);
  EXPECT_THAT(page.body(), HasSubstr("<canvas id=\"view\""));
  EXPECT_THAT(page.body(), HasSubstr("armchair_0"));
  EXPECT_THAT(std::string(page["Content-Security-Policy"]), HasSubstr("default-src 'none'"));
  EXPECT_EQ(page["X-Content-Type-Options"], "nosniff");
  EXPECT_EQ(ask(running.port(), "/", {}, http::verb::head).result_int(), 200);
  for (const char* target :
       {"/page", "/../etc/passwd", "/%2e%2e/etc/passwd", "//", "/live/", "/?", "/recordings/", "/recordings/x.bvh",
        "/recordings/../../etc/passwd.npz", "http://127.0.0.1/", "/recordings/.npz"})
    EXPECT_EQ(ask(running.port(), target).result_int(), 404) << target;
  EXPECT_EQ(ask(running.port(), "/", {}, http::verb::post).result_int(), 405);
  EXPECT_EQ(ask(running.port(), "/live").result_int(), 426) << "no WebSocket was asked for";
  EXPECT_EQ(running.server.address(), "http://" + host_of(running.port()) + "/");
}

TEST(Server, ForeignHostsAndOriginsAreRefused) {
  const Running running;
  const std::string port = std::to_string(running.port());
  EXPECT_EQ(ask(running.port(), "/", {{"Host", "localhost:" + port}}).result_int(), 200);
  for (const std::string& host : std::vector<std::string>{"evil.example", "evil.example:" + port, "127.0.0.1",
                                                          "127.0.0.1:1", "127.0.0.1:" + port + ".evil.example", ""})
    EXPECT_EQ(ask(running.port(), "/", {{"Host", host}}).result_int(), 421) << host;
  EXPECT_EQ(ask(running.port(), "/", {{"Origin", "http://localhost:" + port}}).result_int(), 200);
  for (const std::string& origin :
       std::vector<std::string>{"http://evil.example", "https://127.0.0.1:" + port, "null", "http://127.0.0.1:1",
                                "127.0.0.1:" + port, "http://127.0.0.1:" + port + ".evil.example"}) {
    EXPECT_EQ(ask(running.port(), "/", {{"Origin", origin}}).result_int(), 403) << origin;
    EXPECT_THROW(LiveClient(running.port(), {{"Origin", origin}}), beast::system_error) << origin;
  }
  EXPECT_THROW(LiveClient(running.port(), {{"Host", "evil.example:" + port}}), beast::system_error);
  EXPECT_NO_THROW(LiveClient(running.port(), {{"Origin", "http://127.0.0.1:" + port}}));
  EXPECT_THAT(raw(running.port(), "GET / HTTP/1.1\r\nHost: 127.0.0.1:" + port + "\r\nHost: evil\r\n\r\n"),
              HasSubstr("421"));
  expect_alive(running.port());
}

TEST(Server, WhatIsNoRequestIsRefused) {
  const Running running;
  const std::string host = "Host: " + host_of(running.port()) + "\r\n";
  EXPECT_THAT(raw(running.port(), "hello\r\n\r\n"), HasSubstr("400"));
  EXPECT_THAT(raw(running.port(), std::string(300, '\xff') + "\r\n\r\n"), HasSubstr("400"));
  EXPECT_THAT(raw(running.port(), "GET / HTTP/1.1\r\n" + host + "X: " + std::string(20000, 'x') + "\r\n\r\n"),
              HasSubstr("400"));
  EXPECT_THAT(raw(running.port(), "GET / HTTP/1.1\r\n" + host + "Content-Length: 5\r\n\r\nabcde"), HasSubstr("400"));
  EXPECT_THAT(raw(running.port(), "GET / HTTP/1.1\r\n" + host + "Content-Length: -5\r\n\r\n"), HasSubstr("400"));
  {
    asio::io_context io;
    connected(io, running.port());  // and gone
    tcp::socket half = connected(io, running.port());
    asio::write(half, asio::buffer(std::string("GET / HT")));
  }
  expect_alive(running.port());
}

TEST(Server, APersonIsMovedThirtyTimesASecond) {
  const Running running;
  LiveClient client(running.port());
  EXPECT_TRUE(client.event("hello")["contacts"].get<bool>());
  const auto began = Clock::now();
  const auto first = number_at<uint32_t>(client.pose(), 4);
  uint32_t last = first;
  while (Clock::now() - began < std::chrono::seconds(1)) {
    const auto index = number_at<uint32_t>(client.pose(), 4);
    EXPECT_GT(index, last);
    last = index;
  }
  EXPECT_GT(last - first, 15);
  EXPECT_LT(last - first, 34) << "never faster";
}

TEST(Server, AMessageIsInTheNextFrame) {
  const Running running;
  LiveClient client(running.port());
  std::vector<double> milliseconds;
  for (uint32_t i = 1; i <= 20; ++i) {
    client.pose();
    const auto sent = Clock::now();
    client.send(json{{"do", "walk"}, {"to", {-1.5, 1.5}}, {"number", i}});
    while (number_at<uint32_t>(client.pose(), 8) < i) continue;
    milliseconds.push_back(std::chrono::duration<double, std::milli>(Clock::now() - sent).count());
  }
  EXPECT_LT(*std::min_element(milliseconds.begin(), milliseconds.end()), 50) << "benchmarks/serve.cpp has the figures";
}

TEST(Server, AnswersEachOrderOrSaysWhyNot) {
  const Running running;
  LiveClient client(running.port());
  const interact::Chair& chair = small_world()->seats[0].chair;
  const Eigen::Vector3d arm = interact::contact_on(chair, "armrest", 1);
  client.send(json{{"do", "sit"}, {"chair", "armchair_0"}});
  EXPECT_EQ(client.event("contacts")["chair"], "armchair_0");
  client.send(json{{"do", "contact"}, {"hand", "right"}, {"at", {arm.x(), arm.y() + 0.03, arm.z()}}});
  const json contacts = client.event("contacts");
  EXPECT_TRUE(contacts["left"].is_null());
  EXPECT_NEAR(contacts["right"][1].get<double>(), arm.y(), 0.02);
  const auto said = [&](const json& order) {
    client.send(order);
    const json event = client.event("said");
    EXPECT_TRUE(event["error"].get<bool>());
    return event["text"].get<std::string>();
  };
  EXPECT_THAT(said({{"do", "contact"}, {"hand", "left"}, {"at", {arm.x(), arm.y() + 0.5, arm.z()}}}),
              HasSubstr("in the air"));
  EXPECT_THAT(said({{"do", "sit"}, {"chair", "throne\n<script>"}}), HasSubstr("armchair_0"));
  EXPECT_THAT(said({{"do", "walk"}, {"to", {0.5, -0.4}}}), HasSubstr("nobody can stand there"));
  EXPECT_THAT(said({{"do", "forecast"}, {"on", true}}), HasSubstr("no model"));
  EXPECT_THAT(said({{"do", "futures"}, {"on", true}}), HasSubstr("no model"));
  EXPECT_THAT(said({{"do", "pose"}, {"pose", "step"}, {"at", {0, 2}}, {"heading", 0}}), HasSubstr("no model"));
  EXPECT_THAT(said({{"do", "record"}, {"on", false}}), HasSubstr("nothing is recorded"));
}

TEST(Server, PagesHavePeopleOfTheirOwn) {
  const Running running;
  LiveClient one(running.port()), other(running.port());
  one.send(json{{"do", "sit"}, {"chair", "armchair_0"}, {"number", 5}});
  EXPECT_EQ(one.event("contacts")["chair"], "armchair_0");
  for (int i = 0; i < 10; ++i) {
    const std::string message = other.read();
    EXPECT_FALSE(other.got_text() && message.find("armchair_0\",\"event") != std::string::npos);
    if (!other.got_text()) {
      EXPECT_EQ(number_at<uint32_t>(message, 8), 0);
    }
  }
}

TEST(Server, DamagedMessagesAreSaidAndChangeNothing) {
  const Running running;
  LiveClient client(running.port());
  for (const std::string& text :
       std::vector<std::string>{"", "{", "[]", R"({"do": "walk", "to": [1e999, 0]})",
                                R"({"do": "walk", "to": [1e9, 0]})", R"({"do": "walk", "to": "there"})"}) {
    client.send(text);
    EXPECT_THAT(client.event("said")["text"].get<std::string>(), HasSubstr("message: ")) << text;
  }
  client.send_bytes("\1\2\3");
  EXPECT_THAT(client.event("said")["text"].get<std::string>(), HasSubstr("is no text"));
  client.send(std::string("\xc3\x28"));
  client.closed();
  LiveClient large(running.port());
  // A text of 100000 bytes is announced and never sent: the server may close before all of it could be.
  asio::write(large.plain(), asio::buffer(std::string("\x81\xff\0\0\0\0\0\x01\x86\xa0mask", 14)));
  EXPECT_EQ(large.closed().code, beast::websocket::close_code::too_big);
  LiveClient unmasked(running.port());
  asio::write(unmasked.plain(), asio::buffer(std::string("\x81\x05hello\xff\xff\xff", 10)));
  unmasked.closed();
  expect_alive(running.port());
}

TEST(Server, AFloodEndsTheConnection) {
  const Running running;
  LiveClient client(running.port());
  const std::string stand = R"({"do": "restart"})";
  try {
    for (int i = 0; i < 3000; ++i) client.send(stand);
  } catch (const beast::system_error&) {  // closed meanwhile
  }
  EXPECT_TRUE(soon([&] { return running.server.stats().people == 0; }));
  expect_alive(running.port());
}

TEST(Server, SlowPagesMissFramesAndAreDroppedInTheEnd) {
  Limits limits;
  limits.send_buffer = 4096;
  limits.stuck = std::chrono::milliseconds(1500);
  const Running running(limits);
  LiveClient slow(running.port(), {}, 2048);
  EXPECT_TRUE(soon([&] { return running.server.stats().dropped > 10; })) << "frames are left out";
  EXPECT_TRUE(soon([&] { return running.server.stats().people == 0; })) << "and the page is dropped";
  expect_alive(running.port());
}

TEST(Server, AnswersThatNobodyTakesEndTheConnection) {
  Limits limits;
  limits.send_buffer = 4096;
  limits.messages = 1'000'000;
  const Running running(limits);
  const double before = resident_mb();
  LiveClient client(running.port(), {}, 2048);
  try {
    for (int i = 0; i < 20'000; ++i) client.send(std::string("{"));
  } catch (const beast::system_error&) {
  }
  EXPECT_TRUE(soon([&] { return running.server.stats().people == 0; }));
  EXPECT_LT(resident_mb() - before, 40);
  expect_alive(running.port());
}

TEST(Server, VanishedPagesAreNoticed) {
  Limits limits;
  limits.idle = std::chrono::milliseconds(1000);
  const Running running(limits);
  LiveClient silent(running.port());  // which answers no ping
  { LiveClient gone(running.port()); }
  EXPECT_TRUE(soon([&] { return running.server.stats().people == 0; }));
  EXPECT_TRUE(soon([&] { return running.server.stats().sockets == 0; }));
}

TEST(Server, AHundredPagesAtOnce) {
  const Running running;
  ask(running.port(), "/");
  const double before = resident_mb();
  std::vector<std::unique_ptr<LiveClient>> pages;
  for (int i = 0; i < 100; ++i) pages.push_back(std::make_unique<LiveClient>(running.port()));
  for (const auto& page : pages) {
    EXPECT_EQ(page->event("hello")["chairs"].size(), 1);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(page->pose().size(), 208);
  }
  EXPECT_EQ(running.server.stats().people, 100);
  EXPECT_LT(resident_mb() - before, 200);
  EXPECT_THROW(LiveClient(running.port()), beast::system_error) << "as many as may be";
  EXPECT_EQ(ask(running.port(), "/").result_int(), 200) << "the page itself is still served";
  pages.clear();
  EXPECT_TRUE(soon([&] { return running.server.stats().people == 0; }));
  expect_alive(running.port());
}

TEST(Server, MorePagesThanMayBeAreRefused) {
  Limits limits;
  limits.people = 10;
  limits.sockets = 40;
  const Running running(limits);
  std::vector<std::unique_ptr<LiveClient>> pages;
  int refused = 0;
  for (int i = 0; i < 100; ++i) {
    try {
      pages.push_back(std::make_unique<LiveClient>(running.port()));
    } catch (const beast::system_error&) {
      ++refused;
    }
  }
  EXPECT_EQ(pages.size(), 10);
  EXPECT_EQ(refused, 90);
  ASSERT_TRUE(soon([&] { return running.server.stats().sockets == 10; })) << "the refused are gone";
  asio::io_context io;
  std::vector<tcp::socket> idle;
  for (int i = 0; i < 100; ++i) idle.push_back(connected(io, running.port()));
  EXPECT_TRUE(soon([&] { return running.server.stats().sockets == 40; }));
  for (const auto& page : pages) page->pose();
  idle.clear();
  pages.clear();
  EXPECT_TRUE(soon([&] { return running.server.stats().sockets == 0; }));
  expect_alive(running.port());
}

TEST(Server, RecordingsAreFetchedAndForgotten) {
  TempFolder folder;
  Limits limits;
  limits.recorded = 40;
  const Running running(limits);
  std::string file;
  {
    LiveClient client(running.port());
    client.send(json{{"do", "record"}, {"on", true}});
    for (int i = 0; i < 20; ++i) client.pose();
    client.send(json{{"do", "record"}, {"on", false}});
    const json recorded = client.event("recorded");
    file = "/" + recorded["file"].get<std::string>();
    EXPECT_GE(recorded["frames"].get<int>(), 15);
    for (const char* extension : {"npz", "bvh", "glb"}) {
      const auto answer = ask(running.port(), file + "." + extension);
      EXPECT_EQ(answer.result_int(), 200);
      EXPECT_THAT(std::string(answer["Content-Disposition"]), HasSubstr(std::string("inhabit.") + extension));
      const std::string path = folder / (std::string("m.") + extension);
      std::ofstream(path, std::ios::binary) << answer.body();
      if (extension[0] != 'g') {
        EXPECT_EQ(read_clip(path).frames(), recorded["frames"].get<int>());
      }
    }
    EXPECT_EQ(ask(running.port(), file + ".json").result_int(), 404);
    // As long as one may be, then it ends by itself.
    client.send(json{{"do", "record"}, {"on", true}});
    EXPECT_EQ(client.event("recorded")["frames"], 40);
    EXPECT_EQ(ask(running.port(), file + ".npz").result_int(), 404) << "the one before is forgotten";
  }
  EXPECT_TRUE(soon([&] { return running.server.stats().people == 0; }));
  EXPECT_EQ(ask(running.port(), file + ".npz").result_int(), 404);
}

TEST(Server, SaysGoodbyeAndEnds) {
  auto running = std::make_unique<Running>();
  LiveClient client(running->port());
  client.event("hello");
  const uint16_t port = running->port();
  std::thread end([&] { running.reset(); });
  EXPECT_EQ(client.closed().code, beast::websocket::close_code::going_away);
  end.join();
  EXPECT_THROW(LiveClient{port}, boost::system::system_error);
}

TEST(Server, APortIsTakenOnce) {
  const Running running;
  EXPECT_THAT(refusal_of([&] { Server(small_world(), {running.port(), {}, 1}); }), HasSubstr("cannot be listened on"));
}

}  // namespace
}  // namespace inhabit::serve
