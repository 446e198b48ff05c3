#include <chrono>
#include <future>

#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/serve/server.h"

namespace inhabit::python {
namespace {

/// The live page, served in threads of its own.
class LiveServer {
 public:
  LiveServer(const Scene& scene, const serve::ModelFiles& models, uint16_t port)
      : server_(serve::make_world(scene, serve::with_shipped(models)), {port, {}, 0}) {}
  ~LiveServer() {
    const py::gil_scoped_release none;  // threads that end may have a line to log
    stop();
  }
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  std::string address() const { return server_.address(); }
  void start() {
    if (served_.valid()) throw Error("Server", "serves already, or has ended; make another");
    served_ = std::async(std::launch::async, [this] { server_.run(); });
  }
  /// Until stop(), or an interruption.
  void run() {
    start();
    try {
      while (served_.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) interruption_point();
    } catch (...) {
      stop();
      throw;
    }
  }
  void stop() {
    if (!served_.valid()) return;
    server_.stop();
    served_.wait();
  }

 private:
  serve::Server server_;
  std::shared_future<void> served_;
};

}  // namespace

void add_serve(py::module_& m) {
  py::class_<LiveServer>(
      m, "Server",
      "The live page that `inhabit serve` has, on 127.0.0.1: people walk, sit and put their hands where is clicked.\n\n"
      "    with inhabit.Server(scene) as server:\n"
      "        print(server.address)\n\n"
      "scene: left out, a room with four seats. port: 0 is a free one. model: of interaction, the other three of the\n"
      "previews; left out, those that ship.")
      .def(py::init([](const std::optional<Scene>& scene, uint16_t port, const std::optional<Path>& model,
                       const std::optional<Path>& forecast_model, const std::optional<Path>& inbetween_model,
                       const std::optional<Path>& anticipate_model) {
             const auto text = [](const std::optional<Path>& path) { return path ? path->string() : std::string(); };
             const serve::ModelFiles models{text(model), text(forecast_model), text(inbetween_model),
                                            text(anticipate_model)};
             return released(
                 [&] { return std::make_unique<LiveServer>(scene ? *scene : serve::default_room(), models, port); });
           }),
           "scene"_a = py::none(), "port"_a = 0, py::kw_only(), "model"_a = py::none(), "forecast_model"_a = py::none(),
           "inbetween_model"_a = py::none(), "anticipate_model"_a = py::none())
      .def_property_readonly("address", &LiveServer::address, "'http://127.0.0.1:8080/'.")
      .def(
          "start", [](LiveServer& server) { released([&] { server.start(); }); },
          "Serves from now on, while the program goes on. Once.")
      .def(
          "run", [](LiveServer& server) { released([&] { server.run(); }); },
          "Serves until Ctrl-C, or until stop() is called from another thread.")
      .def(
          "stop", [](LiveServer& server) { released([&] { server.stop(); }); },
          "Says goodbye to all pages that are open and ends; with it the server has ended.")
      .def(
          "__enter__",
          [](LiveServer& server) -> LiveServer& {
            released([&] { server.start(); });
            return server;
          },
          py::return_value_policy::reference, "start().")
      .def(
          "__exit__", [](LiveServer& server, const py::args&) { released([&] { server.stop(); }); }, "stop().");
}

}  // namespace inhabit::python
