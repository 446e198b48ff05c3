#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "control_options.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/inbetween_page.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/warnings.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/io/shipped_model.h"
#include "inputs.h"
#include "outputs.h"
#include "progress.h"
#include "sampler_option.h"
#include "verbs.h"

namespace {

using namespace inhabit;

struct InbetweenArguments {
  std::vector<std::string> motions, outputs;
  std::vector<double> times;
  std::string model, keys, joints;
  ClipReadOptions reading;
  SceneInput scene;
  WriteOptions writing;
  ControlTexts controls;
  bool noisy = false, no_common_skeleton = false;
  uint64_t samples = 1;
  inbetween::Options options;
};

/// The motion whose key frames are given, with them in o.options.keys.
Clip read_keys(InbetweenArguments& o, double rate, Notes& notes) {
  if (o.motions.size() == 1) {
    Clip clip = read_motion(o.motions[0], o.reading, notes);
    if (!o.times.empty()) {
      if (o.keys.find_first_not_of("0123456789, ") != std::string::npos || o.keys.empty())
        throw Error("--times", "of one file need --keyframes: which of its frames stand at them, such as 0,40,95");
      inbetween::PosesInTime in_time = inbetween::frames_at_times(
          clip, inbetween::listed_frames(o.keys, clip.frames(), "--keyframes"), o.times, o.motions[0]);
      o.options.keys = in_time.keys;
      return in_time.clip;
    }
    try {
      o.options.keys =
          inbetween::key_frames(o.keys.empty() ? "ends" : o.keys, clip.frames(), o.options.seed, "--keyframes");
    } catch (const Error& e) {
      throw Error(o.motions[0], e.what());
    }
    return clip;
  }
  if (!o.keys.empty())
    throw Error("--keyframes", "is one list of frames, such as 0,40,95, of one file; several (here " + o.motions[0] +
                                   ", " + o.motions[1] + ") stand at --times");
  std::vector<Clip> poses;
  for (const std::string& motion : o.motions) {
    ClipReadOptions reading = o.reading;
    if (extension_of(motion) != "amc") reading.asf.clear();  // is of those among them that are
    poses.push_back(read_motion(motion, reading, notes));
  }
  inbetween::PosesInTime in_time = inbetween::poses_at_times(poses, o.times, rate, o.motions);
  o.options.keys = in_time.keys;
  o.no_common_skeleton = in_time.standard;
  return in_time.clip;
}

/// What the contacts and targets are called, in their order among the controls.
std::vector<std::string> names_of(const ControlTexts& texts) {
  std::vector<std::string> out;
  for (const std::string& text : texts.contacts) out.push_back("--contact " + text);
  for (const std::string& text : texts.targets) out.push_back("--target " + text);
  return out;
}

void run_inbetween(InbetweenArguments& o) {
  require_motion_outputs(o.outputs, "inbetween.html", "in-betweening");
  require_motion_written(o.writing, o.outputs);
  o.options.standard |= pages_alone(o.outputs);
  const std::string model =
      model_file(o.model, o.noisy ? "inbetween-noisy.safetensors" : "inbetween-compact.safetensors");
  const auto inbetweener = inbetween::SceneInbetweener::load(model);
  if (o.noisy) inbetween::require_noise_aware(inbetweener.config(), model);
  Notes notes;
  const Clip clip = read_keys(o, inbetweener.config().rate, notes);
  set_contacts(o.options.controls, o.controls, clip.skeleton);
  const auto at = [&](int64_t key) { return static_cast<double>(key) / clip.rate; };
  const std::vector<int64_t>& keys = o.options.keys;
  if (!keys.empty())
    require_times(o.options.controls, o.controls, o.times.empty() ? at(keys.front()) : o.times.front(),
                  at(keys.back() - keys.front()));
  const Scene scene = read_scene(o.scene, notes);
  if (!o.joints.empty()) o.options.key_groups = inbetween::key_groups(o.joints, clip.skeleton);
  o.options.name = o.motions[0];
  o.options.keys_name = o.times.empty() ? "--keyframes" : "--times";
  o.options.collisions = std::any_of(o.outputs.begin(), o.outputs.end(),
                                     [](const std::string& out) { return extension_of(out) == "html"; });
  o.options.progress = progress_of("steps of the denoiser");
  const std::vector<inbetween::Result> results =
      inbetweener.run_samples(clip, scene, o.options, static_cast<int64_t>(o.samples));
  const inbetween::Result& r = results.front();
  for (std::string& note : inbetween::notes_of(r)) notes.push_back(std::move(note));
  if (!o.options.standard && (o.no_common_skeleton || !clip.rotations.defined()))
    notes.emplace_back(o.motions.size() == 1
                           ? "the file holds no rotations: written on the standard skeleton"
                           : "the files hold no rotations on one skeleton: written on the standard one");
  for (const std::string& warning : inbetween::warnings_of(r, names_of(o.controls)))
    std::fprintf(stderr, "inhabit: warning: %s\n", warning.c_str());
  say(notes);
  write_outputs(
      o.outputs,
      [&] {
        return inbetween::inbetween_page(results, o.noisy, o.options.key_groups,
                                         "In-betweening of " + std::filesystem::path(o.motions[0]).filename().string());
      },
      [&](const std::string& out) {
        std::vector<Clip> motions;
        motions.reserve(results.size());
        for (const inbetween::Result& result : results)
          motions.push_back(o.options.standard ? result.motion : result.on_source);
        write_clips(out, motions, o.writing, {}, &r.scene);
        return motions.size();
      });
}

}  // namespace

void add_inbetween(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("inbetween", "Fill in the motion between key frames, in a scene");
  auto o = std::make_shared<InbetweenArguments>();
  verb->add_option("motions", o->motions, "A motion file, or several at --times, whose first poses count")->required();
  add_reading(*verb, o->reading, "the motions");
  add_scene(*verb, o->scene, " (without one, a flat floor is assumed)");
  verb->add_option("--keyframes", o->keys,
                   "Key frames of the file: every:N, a list such as 0,30,95, random:P, or ends (default)")
      ->check(not_empty);
  verb->add_option("--times", o->times,
                   "Seconds at which several files' poses stand, or the frames that --keyframes lists of one file")
      ->delimiter(',');
  verb->add_option(
          "--joints", o->joints,
          "Joints that the keys between the ends constrain, such as pelvis,left_wrist; root is the root's path "
          "(default: whole poses)")
      ->check(not_empty);
  verb->add_flag("--noisy", o->noisy, "Key frames are noisy: they are cleaned, but for the ends");
  verb->add_option("--noise", o->options.noise,
                   "With --noisy: how noisy, so many degrees and cm (default: as all frames of the file tell it)")
      ->check(CLI::Range(0.0, 10.0))
      ->needs("--noisy");
  verb->add_option("--model", o->model, "Model file (default: the one that ships)");
  add_sampler(*verb, o->options.sampler);
  verb->add_option("--steps", o->options.steps, "Evaluations of the denoiser (default: the model's own, 2)")
      ->check(CLI::Range(1, 1000));
  verb->add_option("--seed", o->options.seed, "Seed of the noise and of random key frames")
      ->check(whole_number)
      ->capture_default_str();
  verb->add_option("--temperature", o->options.temperature,
                   "How much of the motion's course is left to the seed: 0 the likeliest course (default), 1 any that "
                   "people take (default of several --samples)")
      ->check(CLI::Range(0.0, 2.0))
      ->option_text("FLOAT");
  verb->add_option("--samples", o->samples, "How many motions, with seeds from --seed on")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_controls(*verb, o->options.controls, o->controls);
  verb->add_flag_callback(
      "--no-refine", [o] { o->options.refine = false; }, "Leave the motion as the network makes it");
  verb->add_option(
          "--detours", o->options.detours,
          "Around what stands between keys: learned (PathNet's path, the default), searched (A*'s) or straight "
          "(the denoiser alone goes around)")
      ->transform(one_of<inhabit::inbetween::Detours>(inhabit::inbetween::detours_by_name()))
      ->option_text("NAME");
  verb->add_flag("--standard", o->options.standard,
                 "Write the standard 22 joints at the model's rate, not the file's skeleton and rate");
  add_writing(*verb, o->writing, /*loop=*/false);
  add_outputs(*verb, o->outputs,
              "Output files: .npz .bvh .glb .json hold the motion (of several samples .npz all, the others a file "
              "each), .html is a page (default: inbetween.html)");
  verb->callback([o] { run_inbetween(*o); });
}
