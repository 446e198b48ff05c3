#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/interact/contact_area.h"
#include "inhabit/interact/contact_script.h"
#include "inhabit/interact/contacts_page.h"
#include "inhabit/interact/interaction_page.h"
#include "inhabit/interact/warnings.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/io/number_list.h"
#include "inhabit/io/shipped_model.h"
#include "inputs.h"
#include "outputs.h"
#include "progress.h"
#include "verbs.h"

namespace {

using namespace inhabit;
using interact::HandContacts;

struct InteractArguments {
  std::string start_file, start, model, left, right, contacts, hold, sit_at, then_walk;
  ClipReadOptions reading;
  SceneInput scene;
  WriteOptions writing;
  int samples = 0;
  std::vector<std::string> outputs;
  interact::Options options;
};

/// Where a hand goes as --left and --right have it.
std::optional<Eigen::Vector3d> contact_of(const std::string& text, const interact::Chair& chair, int side) {
  const std::string option = side == 0 ? "--left" : "--right";
  interact::ContactPlace place;
  if (text.find(',') != std::string::npos) {
    const std::vector<double> p = listed_numbers(text, 3, option);
    place = Eigen::Vector3d(p[0], p[1], p[2]);
  } else if (!text.empty()) {
    place = text;
  }
  try {
    return interact::contact_at(chair, place, side);
  } catch (const Error& e) {
    throw Error(option, e.what());
  }
}

/// x, z and heading in degrees.
Eigen::Vector3d place_of(const std::vector<double>& at) { return {at[0], at[1], at[2] * M_PI / 180}; }

/// Whose last pose the person starts in, and in `options` what errors call it; without frames they are placed before
/// the chair.
Clip start_of(InteractArguments& o, Notes& notes) {
  if (!o.start_file.empty()) {
    o.options.name = o.start_file;
    return read_motion(o.start_file, o.reading, notes);
  }
  if (o.start.empty()) return {};
  o.options.name = "--start";
  const Eigen::Vector3d place = place_of(listed_numbers(o.start, 3, "--start"));
  return interact::standing_clip(place.head<2>(), place[2]);
}

/// Sets what hands are to do, of the chair that is sat on.
void set_hands(InteractArguments& o, const interact::ChairInteractor& interactor, const Clip& start,
               const Scene& scene) {
  o.options.draw_contacts = o.samples > 0;
  if (o.contacts.empty() && o.left.empty() && o.right.empty()) return;
  const interact::Chair chair = interactor.chair_of(start, scene, o.options);
  if (o.contacts.empty()) {
    o.options.contacts = {{contact_of(o.left, chair, 0), contact_of(o.right, chair, 1)}};
    return;
  }
  const interact::ContactScript script = interact::read_contact_script(o.contacts, chair);
  o.options.contacts = script.contacts;
  if (script.then_walk) o.options.then_walk = script.then_walk;
}

void say_results(const std::vector<interact::Result>& results, double seconds) {
  for (const interact::Result& r : results)
    for (const auto& errors : r.contact_error)
      for (int side = 0; side < 2; ++side)
        if (errors[static_cast<size_t>(side)])
          std::printf("%s hand: %.1f cm from its contact\n", side == 0 ? "left" : "right",
                      100 * *errors[static_cast<size_t>(side)]);
  for (size_t i = 0; i < results.size(); ++i) {
    const std::string who = results.size() > 1 ? "sample " + std::to_string(i + 1) + ": " : "";
    for (const std::string& warning : interact::warnings_of(results[i], seconds))
      std::fprintf(stderr, "inhabit: warning: %s%s\n", who.c_str(), warning.c_str());
  }
}

void run_interact(InteractArguments& o) {
  require_motion_outputs(o.outputs, "interact.html", "interaction");
  require_motion_written(o.writing, o.outputs);
  if (o.scene.file.empty()) throw Error("--scene", "is needed: it holds the chair");
  Notes notes;
  const Scene scene = read_scene(o.scene, notes);
  const auto interactor = interact::ChairInteractor::load(model_file(o.model, "interact-compact.safetensors"));
  if (!o.sit_at.empty()) {
    const std::vector<double> at = listed_numbers(o.sit_at, 4, "--sit-at");
    o.options.sit_at = Eigen::Vector4d(at[0], at[1], at[2], at[3] * M_PI / 180);
  }
  if (!o.then_walk.empty()) o.options.then_walk = place_of(listed_numbers(o.then_walk, 3, "--then-walk"));
  if (!o.hold.empty()) o.options.hold = o.hold == "end" ? HUGE_VAL : listed_numbers(o.hold, 1, "--hold").front();
  const Clip start = start_of(o, notes);
  set_hands(o, interactor, start, scene);
  o.options.progress = progress_of("frames");
  const std::vector<interact::Result> results = interactor.run_samples(start, scene, o.options, std::max(1, o.samples));
  say(notes);
  say_results(results, o.options.seconds);
  std::vector<Clip> motions;
  motions.reserve(results.size());
  // From a file on its own skeleton: what follows on it.
  const bool own = !o.start_file.empty() && !o.options.standard;
  for (const interact::Result& r : results) motions.push_back(own && r.on_source.frames() > 0 ? r.on_source : r.motion);
  write_outputs(
      o.outputs, [&] { return interact::interaction_page(results, scene); },
      [&](const std::string& out) {
        write_clips(out, motions, o.writing, {}, &scene);
        return motions.size();
      });
}

}  // namespace

void add_interact(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("interact", "Sit down on a chair with the hands where they are wanted");
  auto o = std::make_shared<InteractArguments>();
  CLI::Option* start_motion =
      verb->add_option("start_motion", o->start_file, "Motion whose last pose the person starts in");
  add_reading(*verb, o->reading, "the start motion");
  for (const char* of_motion : {"--up", "--scale", "--input-rate", "--level", "--asf"})
    verb->get_option(of_motion)->needs(start_motion);
  add_scene(*verb, o->scene);
  CLI::Option* on = verb->add_option("--chair", o->options.chair,
                                     "Object of the scene to sit on, or auto (default: the nearest seat)");
  verb->add_option("--sit-at", o->sit_at, "x,y,z,heading: sit here instead, facing that many degrees from +Z to +X")
      ->excludes(on);
  verb->add_option("--start", o->start, "x,z,heading: where the person starts, standing (default: 2 m before the seat)")
      ->excludes(start_motion);
  CLI::Option* left =
      verb->add_option("--left", o->left,
                       "Contact of the left hand: armrest, front, side, back, none, or x,y,z in metres, +Y up "
                       "whatever the files' axes");
  CLI::Option* right = verb->add_option("--right", o->right, "Contact of the right hand");
  CLI::Option* series =
      verb->add_option("--contacts", o->contacts, "JSON file: a series of contacts, the next once one is reached")
          ->excludes(left)
          ->excludes(right);
  verb->add_option("--hold", o->hold,
                   "Seconds that hands stay at each of their contacts (default: 2); end: at the last until the end");
  verb->add_option("--then-walk", o->then_walk, "x,z,heading: get up in the end and walk there");
  verb->add_flag("--straight", o->options.straight, "Plan no route around what stands in the way");
  verb->add_flag("--standard", o->options.standard, "Motion on the standard skeleton, not the file's");
  verb->add_option("--samples", o->samples, "Draw contacts by ContactNet, this many times")
      ->check(CLI::Range(1, 1000))
      ->excludes(left)
      ->excludes(right)
      ->excludes(series);
  verb->add_option("--seconds", o->options.seconds, "Length of the motion")
      ->check(positive_number)
      ->capture_default_str();
  verb->add_option("--seed", o->options.seed, "Seed of contacts that are drawn")
      ->check(whole_number)
      ->capture_default_str();
  verb->add_flag(
      "--raw", o->options.raw,
      "The networks' motion as it is: a motion before does not fade into it, and it is not fitted to contacts, "
      "floor and chair");
  verb->add_flag("--force", o->options.force,
                 "Try seats of any height, contacts out of reach, starts inside something and walks out of the scene");
  verb->add_option("--model", o->model, "Model file (default: the one that ships)");
  add_writing(*verb, o->writing);
  add_outputs(*verb, o->outputs, "Output files: .npz .bvh .glb .json hold the motion, .html is a page");
  verb->callback([o] { run_interact(*o); });
}

void add_contacts(CLI::App& app) {
  struct Arguments {
    SceneInput scene;
    std::string chair, model, out = "contacts.html";
    bool force = false;
    int samples = 10;
    uint64_t seed = 1;
  };
  CLI::App* verb = app.add_subcommand("contacts", "Propose where hands touch a chair (ContactNet)");
  auto o = std::make_shared<Arguments>();
  CLI::Option* file = verb->add_option("scene", o->scene.file, "Mesh of a chair, or a scene that holds one");
  file->required();
  add_scene_reading(*verb, o->scene, file);
  verb->add_option("--chair", o->chair, "Object of the scene (default: the seat nearest to the scene's origin)");
  verb->add_flag("--force", o->force, "Take seats of any height");
  verb->add_option("--samples", o->samples, "How many")->check(CLI::Range(1, 1000))->capture_default_str();
  verb->add_option("--seed", o->seed, "Seed")->check(whole_number)->capture_default_str();
  verb->add_option("--model", o->model, "Model file (default: the one that ships)");
  verb->add_option("-o,--out", o->out, "A page (.html), or the points as .json")->capture_default_str();
  verb->callback([o] {
    const bool page = extension_of(o->out) == "html";
    if (!page && extension_of(o->out) != "json") throw Error(o->out, "is no output of contacts: .html or .json");
    require_writable(o->out);
    Notes notes;
    const Scene scene = read_scene(o->scene, notes);
    const auto interactor = interact::ChairInteractor::load(model_file(o->model, "interact-compact.safetensors"));
    interact::Options options;
    options.chair = o->chair;
    options.force = o->force;
    const interact::Chair chair = interactor.chair_of({}, scene, options);
    const std::vector<HandContacts> drawn = interactor.draw_contacts(chair, o->samples, o->seed);
    say(notes);
    if (page)
      write_page(o->out, interact::contacts_page(drawn, chair, scene));
    else
      write_atomically(o->out, interact::contacts_json(drawn).dump(1) + "\n");
    std::printf("%s: %zu contacts on %s\n", o->out.c_str(), drawn.size(), chair.name.c_str());
  });
}
