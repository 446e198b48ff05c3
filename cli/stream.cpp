#include <csignal>
#include <cstdio>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/serve/line_stream.h"
#include "inputs.h"
#include "progress.h"
#include "verbs.h"

namespace {

using namespace inhabit;

struct StreamArguments {
  std::string model;
  SceneInput scene;
  UpAxis up = UpAxis::y;
  serve::LineOptions lines;
  bool refine = false;
  forecast::StreamOptions forecast;
  anticipate::StreamOptions anticipate;
};

void add_poses(CLI::App& verb, StreamArguments& o, PoseStreamOptions& poses, const std::string& what) {
  verb.add_option("--model", o.model, "Model file (default: the one that ships)");
  verb.add_option("--rate", poses.rate, what + " a second of each person, by the time stamps")
      ->check(positive_number)
      ->capture_default_str();
  verb.add_flag("--live", o.lines.live, "Leave out what cannot be kept up with (default: one for every time)");
  verb.add_option("--up", o.up, "Axis of the joints that points up, y or z (as in ROS); what comes out has it too")
      ->transform(one_of<UpAxis>({{"y", UpAxis::y}, {"z", UpAxis::z}}))
      ->option_text("y|z");
  verb.add_option("--every", o.lines.every, "Write every so many frames")->check(CLI::Range(1, 1000));
  verb.add_option("--gap", poses.longest_gap, "Seconds without a pose after which a person begins anew")
      ->check(CLI::Range(0.001, 60.0))
      ->capture_default_str();
  verb.add_option("--people", poses.people, "People at once, at most")->check(whole_over_zero)->capture_default_str();
}

/// From standard input to standard output, until the one ends or nobody reads the other.
void answer(const serve::LineStream& stream, StreamArguments& o, const Notes& notes) {
  o.lines.z_up = o.up == UpAxis::z;
  serve::validate(o.lines, stream);
  if (!is_quiet())
    for (const std::string& note : notes) std::fprintf(stderr, "%s\n", note.c_str());
  std::signal(SIGPIPE, SIG_IGN);
  serve::answer_lines(0, stream, o.lines, [](const std::string& line) {
    if (std::fwrite(line.data(), 1, line.size(), stdout) != line.size() || std::fflush(stdout) != 0)
      throw Error("standard output", "is read by nobody any more");
  });
}

void add_stream_forecast(CLI::App& stream) {
  CLI::App* verb = stream.add_subcommand("forecast", "The next two seconds of each person");
  auto o = std::make_shared<StreamArguments>();
  add_scene(*verb, o->scene, " (without one, a flat floor is assumed)");
  add_poses(*verb, *o, o->forecast.poses, "Forecasts");
  verb->add_option("--points", o->forecast.forecast.points,
                   "Scene points to look at; fewer are faster (default: as the model was trained)")
      ->check(CLI::Range(16, 60000));
  verb->add_option("--seed", o->forecast.forecast.seed, "Seed of the points")
      ->check(whole_number)
      ->capture_default_str();
  verb->add_flag("--refine", o->refine, "Feet stand, nobody is inside the scene: nearly four times as slow");
  verb->callback([o] {
    Notes notes;
    const Scene scene = read_scene(o->scene, notes);
    if (scene.empty()) notes.emplace_back("no scene given: a flat floor under the feet is assumed");
    o->forecast.forecast.joints_alone = !o->refine;
    o->forecast.forecast.standard = true;
    auto forecaster = std::make_shared<const forecast::ContactForecaster>(
        forecast::ContactForecaster::load(model_file(o->model, "forecast-compact.safetensors")));
    answer(serve::forecast_lines(forecaster, scene, o->forecast), *o, notes);
  });
}

void add_stream_anticipate(CLI::App& stream) {
  CLI::App* verb = stream.add_subcommand("anticipate", "Several futures of each person");
  auto o = std::make_shared<StreamArguments>();
  add_poses(*verb, *o, o->anticipate.poses, "Answers");
  verb->add_option("--samples", o->anticipate.anticipate.samples, "Futures of each person")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--seconds", o->anticipate.anticipate.seconds, "How far they go")
      ->check(CLI::Range(0.04, 60.0))
      ->capture_default_str();
  verb->add_option("--seed", o->anticipate.anticipate.seed, "Seed of the futures")
      ->check(whole_number)
      ->capture_default_str();
  verb->callback([o] {
    auto anticipator = std::make_shared<const anticipate::IntentionAnticipator>(
        anticipate::IntentionAnticipator::load(model_file(o->model, "anticipate-cmu.safetensors")));
    answer(serve::anticipate_lines(anticipator, o->anticipate), *o, {});
  });
}

}  // namespace

void add_stream(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("stream", "People's joints in, line by line, and what they will do next out");
  verb->require_subcommand(1);
  verb->footer(
      "A line in is JSON: {\"time\":1.2,\"person\":\"a\",\"joints\":[[x,y,z],...]}; docs/robots.md has the rest.");
  add_stream_forecast(*verb);
  add_stream_anticipate(*verb);
}
