#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/file_notes.h"
#include "inhabit/io/files.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/io/smpl_model.h"
#include "inhabit/nn/used_settings.h"
#include "inhabit/reconstruct/evaluate.h"
#include "inhabit/reconstruct/input_files.h"
#include "inhabit/reconstruct/reconstruction_page.h"
#include "inputs.h"
#include "interrupted.h"
#include "outputs.h"
#include "progress.h"
#include "settings.h"
#include "verbs.h"

namespace {

using namespace inhabit;

struct ReconstructArguments {
  reconstruct::InputFiles files;
  std::vector<std::string> outputs;
  std::string model, body, scene;
  double rate = 0;
  WriteOptions writing;
  reconstruct::Options options;
};

inbetween::SceneInbetweener noise_aware(const std::string& given, const std::vector<std::string>& settings = {}) {
  const std::string model = model_file(given, "inbetween-noisy.safetensors");
  inbetween::Networks networks = inbetween::load_networks(model);
  inbetween::require_noise_aware(networks.config, model);
  set_used(networks.config, settings);
  return inbetween::SceneInbetweener(networks);
}

void say_result(const reconstruct::Result& r) {
  std::printf("depth is %.5g x + %.3f m: the person's points are %.0f mm from the body\n", r.depth.scale.scale,
              r.depth.scale.offset, 1e3 * r.depth.after);
  for (const reconstruct::PlacedObject& o : r.objects)
    std::printf(
        "%s: %.4g times as large, turned by %.1f degrees, at %.2f, %.2f, %.2f: %lld points of it %.0f mm from its "
        "surface\n",
        o.name.c_str(), o.placement.scale, 57.29578 * o.placement.yaw, o.placement.shift.x(), o.placement.shift.y(),
        o.placement.shift.z(), static_cast<long long>(o.points), 1e3 * o.distance);
  std::printf("floor at %.2f m; key frames moved by %.0f mm in the mean\n", r.floor, 1e3 * r.moved);
}

void run_reconstruct(ReconstructArguments& o) {
  require_motion_outputs(o.outputs, "reconstruction.html", "a reconstruction");
  require_motion_written(o.writing, o.outputs);
  if (!o.scene.empty()) {
    if (extension_of(o.scene) != "glb") throw Error(o.scene, "is no output of a scene: .glb");
    require_writable(o.scene);
  }
  o.options.standard |= pages_alone(o.outputs);
  o.options.collisions = std::any_of(o.outputs.begin(), o.outputs.end(),
                                     [](const std::string& out) { return extension_of(out) == "html"; });
  BodyModel body;
  if (!o.body.empty()) body = read_smpl_model(o.body);
  Notes notes, of_motion;
  ClipReadOptions reading;
  reading.up = UpAxis::y;  // the camera's file tells where gravity is
  reading.rate = o.rate;
  if (!o.body.empty()) reading.body = o.options.body = &body;
  const reconstruct::Inputs inputs = reconstruct::open_inputs(o.files, reading, &of_motion);
  add_notes(notes, std::move(of_motion), o.files.motion);
  const auto inbetweener = noise_aware(o.model);
  o.options.name = o.files.motion;
  o.options.progress = progress_of("depth maps");
  const reconstruct::Result r = reconstruct::run(inputs, inbetweener, o.options);
  notes.insert(notes.end(), r.notes.begin(), r.notes.end());
  say(notes);
  say_result(r);
  write_outputs(
      o.outputs,
      [&] { return reconstruct::reconstruction_page(r, std::filesystem::path(o.files.motion).filename().string()); },
      [&](const std::string& out) {
        write_clips(out, {o.options.standard ? r.motion : r.on_source}, o.writing, {}, &r.scene);
        return size_t{1};
      });
  if (!o.scene.empty()) {
    write_scene(o.scene, r.scene);
    std::printf("%s\n", o.scene.c_str());
  }
}

}  // namespace

void add_reconstruct(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("reconstruct",
                                      "A person's motion and the room around them, from what networks made of a video");
  auto o = std::make_shared<ReconstructArguments>();
  verb->add_option("--motion", o->files.motion, "The person's motion as estimated, frame by frame of the video")
      ->required();
  verb->add_option("--camera", o->files.camera, "Camera file (.json)")->required();
  verb->add_option("--depth", o->files.depth, "Depth maps (.npy), numbered: a pattern such as 'depth_*.npy'")
      ->required();
  verb->add_option("--masks", o->files.masks, "Where the person is (.png), numbered as the depth maps are")->required();
  verb->add_option("--objects", o->files.objects, "Folder with a mesh of each object, +Y up, of any size");
  verb->add_option("--object-masks", o->files.object_masks,
                   "Folder with masks of the objects: NAME_NUMBER.png, or NAME.png for every frame");
  verb->add_option("--body", o->body, "SMPL, SMPL-H or SMPL-X model file (.npz) of the person (default: built in)");
  verb->add_option("--input-rate", o->rate, "Frames a second of the motion, whatever its file says")->check(frame_rate);
  verb->add_option("--uncertainty", o->options.uncertainty,
                   "Several maps of a frame: a depth counts where their standard deviation is at most this part of the "
                   "frame's spread of depths")
      ->check(positive_number)
      ->capture_default_str();
  verb->add_flag_callback(
      "--body-scale", [o] { o->options.floor_scale = false; },
      "Tell the depth's scale by the body alone, as the paper does, not by the floor under it too");
  verb->add_option("--key-step", o->options.key_step, "Frames (30 a second) between key frames that are optimised")
      ->check(CLI::Range(1, 30))
      ->capture_default_str();
  verb->add_option("--keep-every", o->options.keep_every, "Of these, every so many are keys of in-betweening")
      ->check(CLI::Range(1, 20))
      ->capture_default_str();
  verb->add_option("--model", o->model, "Noise-aware model of in-betweening (default: the one that ships)");
  verb->add_option("--steps", o->options.steps, "Evaluations of the denoiser (default: the model's own)")
      ->check(CLI::Range(1, 1000));
  verb->add_option("--seed", o->options.seed, "Seed of the noise")->check(whole_number)->capture_default_str();
  verb->add_flag("--standard", o->options.standard,
                 "Write the standard 22 joints at the model's rate, not the file's skeleton and rate");
  verb->add_option("--scene-out", o->scene, "Also write the room: floor and objects, and all else as points (.glb)");
  add_writing(*verb, o->writing);
  add_outputs(*verb, o->outputs,
              "Output files: .npz .bvh .glb .json hold the motion, .html is a page (default: reconstruction.html)");
  verb->callback([o] { run_reconstruct(*o); });
}

void add_eval_reconstruct(CLI::App& eval) {
  struct Arguments {
    reconstruct::Evaluation evaluation;
    std::string model, json, shard;
    std::vector<std::string> settings;
    bool no_objects = false;
  };
  CLI::App* verb = eval.add_subcommand("reconstruct", "Reconstruction of rendered rooms with known errors");
  auto o = std::make_shared<Arguments>();
  reconstruct::Evaluation& e = o->evaluation;
  verb->add_option("--rooms", e.rooms, "Rooms, with a person in each")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  verb->add_option("--seed", e.seed, "Seed of rooms, people and errors")->check(whole_number)->capture_default_str();
  verb->add_option("--seconds", e.seconds, "Length of each video")
      ->check(CLI::Range(1.0, 600.0))
      ->capture_default_str();
  verb->add_option("--width", e.render.width, "Pixels of an image's row; its height is 3/4 of that")
      ->check(CLI::Range(32, 4096))
      ->capture_default_str();
  verb->add_option("--maps", e.render.errors.maps, "Depth maps of each frame")
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
  verb->add_option("--noise", e.render.errors.noise, "Noise of depth at each pixel, part of it")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  verb->add_option("--warp", e.render.errors.warp, "Smooth error of depth, part of it")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  verb->add_flag_callback(
      "--body-scale", [o] { o->evaluation.options.floor_scale = false; },
      "The depth's scale by the body alone, as the paper does");
  verb->add_flag("--no-objects", o->no_objects, "Only the body: no object meshes");
  verb->add_option("--model", o->model, "Noise-aware model of in-betweening (default: the one that ships)");
  add_settings(*verb, o->settings);
  verb->add_option("--keep", e.keep,
                   "Folder that the first room's files are written to, as `inhabit reconstruct` reads them");
  verb->add_option("--json", o->json, "Also write the table as JSON");
  add_evaluation_shard(*verb, o->shard);
  verb->callback([o, verb] {
    if (!o->json.empty()) require_writable(o->json);
    reconstruct::Evaluation& evaluation = o->evaluation;
    evaluation.parts = measured_parts(*verb, o->shard, o->json);
    const GoesOnLater later(kept_of(evaluation.parts));
    evaluation.objects = !o->no_objects;
    evaluation.render.height = evaluation.render.width * 3 / 4;
    evaluation.progress = progress_of("rooms");
    const std::vector<reconstruct::Errors> errors =
        reconstruct::evaluate(noise_aware(o->model, o->settings), evaluation);
    if (errors.empty()) return say_part(evaluation.parts);
    const ScoreTable table = reconstruct::table_of(errors);
    if (!o->json.empty()) write_atomically(o->json, rows_json(table).dump(2) + "\n");
    evaluation.parts.remove();
    std::printf("%s", text_of(table).c_str());
  });
}
