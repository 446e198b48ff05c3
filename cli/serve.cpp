#include <cstdio>
#include <memory>

#include "inhabit/serve/server.h"
#include "inputs.h"
#include "verbs.h"

namespace {

struct ServeArguments {
  SceneInput scene;
  inhabit::serve::ModelFiles models;
  uint16_t port = 8080;
};

}  // namespace

void add_serve(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("serve", "A live page: click where a person walks and sits, and put their hands");
  auto o = std::make_shared<ServeArguments>();
  add_scene(*verb, o->scene, " (without one, a room with four seats)");
  verb->add_option("--model", o->models.interact, "Model of interaction (default: the one that ships)");
  verb->add_option("--forecast-model", o->models.forecast,
                   "Model of forecasts (default: the one that ships, where it is there)");
  verb->add_option("--inbetween-model", o->models.inbetween, "Model of in-betweening (likewise)");
  verb->add_option("--anticipate-model", o->models.anticipate, "Model of anticipation (likewise)");
  verb->add_option("--port", o->port, "Port on 127.0.0.1; 0: a free one")->capture_default_str();
  verb->callback([o] {
    using namespace inhabit;
    Notes notes;
    const Scene scene = o->scene.file.empty() ? serve::default_room() : read_scene(o->scene, notes);
    serve::ServerOptions options;
    options.port = o->port;
    serve::Server server(serve::make_world(scene, serve::with_shipped(o->models)), options);
    say(notes);
    std::printf("%s (Ctrl-C ends it)\n", server.address().c_str());
    std::fflush(stdout);
    server.run(/*signals=*/true);
  });
}
