#include "inhabit/anticipate/anticipation_page.h"

#include <filesystem>
#include <memory>

#include "inhabit/io/shipped_model.h"
#include "inputs.h"
#include "outputs.h"
#include "progress.h"
#include "verbs.h"

namespace fs = std::filesystem;

namespace {

struct AnticipateArguments {
  std::string motion, model;
  inhabit::ClipReadOptions reading;
  std::vector<std::string> outputs;
  inhabit::WriteOptions writing;
  inhabit::anticipate::Options anticipate;
  SceneInput scene;
};

}  // namespace

void add_anticipate(CLI::App& app) {
  CLI::App* verb =
      app.add_subcommand("anticipate", "Many plausible futures of a person's motion, up to 30 s and beyond");
  auto o = std::make_shared<AnticipateArguments>();
  verb->add_option("motion", o->motion, "Motion file")->required();
  add_reading(*verb, o->reading);
  verb->add_option(
          "--start", o->anticipate.start,
          "First frame to forecast, in the file's frames; the two seconds before it are observed (default: the end)")
      ->check(whole_number);
  verb->add_option("--samples", o->anticipate.samples, "How many futures")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--seconds", o->anticipate.seconds, "How far")
      ->check(positive_number)
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  verb->add_option("--seed", o->anticipate.seed, "Seed of the futures")->check(whole_number)->capture_default_str();
  verb->add_flag("--solve", o->anticipate.solve,
                 "Find the joint rotations over all frames together, seconds a future, instead of frame by frame");
  add_scene(*verb, o->scene, ", which futures are steered around");
  verb->add_flag("--refine", o->anticipate.refine,
                 "Feet stand, and nobody is inside the scene: a quarter of a second for each half minute of a future, "
                 "more in a room");
  verb->add_option("--model", o->model, "Model file (default: the one that ships)");
  verb->add_flag("--standard", o->anticipate.standard,
                 "Write the standard 22 joints at the model's rate, not the file's skeleton and rate");
  add_writing(*verb, o->writing);
  add_outputs(*verb, o->outputs,
              "Output files: .npz holds all futures, .html is a page, .bvh .glb .json have one file a future "
              "(default: futures.html)");
  verb->callback([o] {
    using namespace inhabit;
    require_motion_outputs(o->outputs, "futures.html", "an anticipation");
    require_motion_written(o->writing, o->outputs);
    o->anticipate.standard |= pages_alone(o->outputs);
    Notes notes;
    const Clip clip = read_motion(o->motion, o->reading, notes);
    const Scene scene = read_scene(o->scene, notes);
    const auto anticipator = anticipate::IntentionAnticipator::load(model_file(o->model, "anticipate-cmu.safetensors"));
    o->anticipate.name = o->motion;
    o->anticipate.progress = progress_of("futures");
    const anticipate::Result a = anticipator.run(clip, scene, o->anticipate);
    say(notes);
    write_outputs(
        o->outputs,
        [&] { return anticipate::anticipation_page(a, "Futures of " + fs::path(o->motion).filename().string()); },
        [&](const std::string& out) {
          const bool standard = o->anticipate.standard;
          write_clips(out, standard ? a.futures : a.on_source, o->writing,
                      {{"intention", standard ? a.labels : a.labels_on_source}});
          return a.futures.size();
        });
  });
}
