#include <spdlog/spdlog.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/forecast/forecast_clip.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/view/page.h"
#include "models.h"
#include "outputs.h"
#include "progress.h"
#include "sampler_option.h"
#include "verbs.h"

namespace {

using namespace inhabit;

struct InbetweenArguments {
  std::vector<std::string> motions, outputs;
  std::vector<double> times;
  std::string scene, model, keys, joints;
  bool noisy = false;
  InbetweenRequest request;
};

/// One-pose files (of longer ones the first pose counts) at the times given, each held until the next: a clip whose key
/// frames are those times.
Clip clip_of_poses(const InbetweenArguments& o, double rate, std::vector<int64_t>& keys) {
  if (o.times.size() != o.motions.size())
    throw Error("--times", "names " + std::to_string(o.times.size()) + " times for " +
                               std::to_string(o.motions.size()) + " files");
  std::vector<torch::Tensor> joints, rotations, trans;
  Clip out;
  for (size_t i = 0; i < o.motions.size(); ++i) {
    const int64_t key = std::llround((o.times[i] - o.times[0]) * rate);
    if (i > 0 && key <= keys.back()) throw Error("--times", "are not in order, a frame or more apart");
    if (key > 100'000) throw Error("--times", "are more than 55 minutes apart");
    const Clip pose = slice(retarget(read_clip(o.motions[i]), o.motions[i]), 0, 1);
    if (i == 0) {
      out.skeleton = pose.skeleton;
      out.betas = pose.betas;
    } else if ((pose.skeleton.offsets - out.skeleton.offsets).slice(0, 1).abs().max().item<double>() > 0.02) {
      throw Error(o.motions[i], "has other bones than " + o.motions[0]);
    }
    const int64_t held = i == 0 ? 1 : key - keys.back();
    // Frames between keys are not looked at; they repeat the pose before.
    if (i > 0)
      for (auto* all : {&joints, &rotations, &trans}) {
        std::vector<int64_t> shape(static_cast<size_t>(all->back().dim()), -1);
        shape[0] = held - 1;
        if (held > 1) all->push_back(all->back().slice(0, 0, 1).expand(shape));
      }
    joints.push_back(pose.joints);
    rotations.push_back(pose.rotations);
    trans.push_back(pose.trans);
    keys.push_back(key);
  }
  out.rate = rate;
  out.joints = torch::cat(joints);
  out.rotations = torch::cat(rotations);
  out.trans = torch::cat(trans);
  return out;
}

}  // namespace

void add_inbetween(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("inbetween", "Fill in the motion between key frames, in a scene");
  auto o = std::make_shared<InbetweenArguments>();
  verb->add_option("motions", o->motions, "A motion file, or several of one pose each, at --times")->required();
  verb->add_option("--scene", o->scene, "Scene file: a mesh or a point cloud (without one, a flat floor is assumed)");
  verb->add_option("--keyframes", o->keys,
                   "Frames that are given: every:N, a list such as 0,30,95, random:P, or ends (default)");
  verb->add_option("--times", o->times, "Seconds at which several files' poses stand")->delimiter(',');
  verb->add_option("--joints", o->joints,
                   "Joints that the keys between the ends give, such as pelvis,left_wrist; root is the root's path "
                   "(default: whole poses)");
  verb->add_flag("--noisy", o->noisy, "Key frames are noisy: they are cleaned, but for the ends");
  verb->add_option("--model", o->model, "Model file (default: the one that ships)");
  add_sampler(*verb, o->request.sampler);
  verb->add_option("--steps", o->request.steps, "Evaluations of the denoiser")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--seed", o->request.seed, "Seed of the noise and of random key frames")->capture_default_str();
  verb->add_flag("!--loose-feet", o->request.clean_feet, "Leave feet as the network moves them");
  verb->add_option("-o,--out", o->outputs,
                   "Output files: .npz .bvh .glb .json hold the motion, .html is a page (default: inbetween.html)");
  verb->callback([o] {
    require_motion_outputs(o->outputs, "inbetween.html", "in-betweening");
    const std::string model =
        !o->model.empty() ? o->model
                          : shipped_model(o->noisy ? "inbetween-noisy.safetensors" : "inbetween-compact.safetensors");
    const auto inbetweener = SceneInbetweener::load(model);
    const double rate = inbetweener.config().rate;
    if (o->noisy && inbetweener.config().t_star == 0) throw Error(model, "was not trained on noisy key frames");
    Clip clip;
    if (o->motions.size() > 1) {
      if (!o->keys.empty()) throw Error("--keyframes", "is for one file; several stand at --times");
      clip = clip_of_poses(*o, rate, o->request.keys);
    } else {
      if (!o->times.empty()) throw Error("--times", "is for several files; one has --keyframes");
      if (o->keys.empty()) o->keys = "ends";
      const std::string& motion = o->motions[0];
      const Clip source = read_clip(motion);
      clip = resample(retarget(source, motion), rate);
      // Key frames are named in the file's own frames.
      for (const int64_t key : key_frames(o->keys, source.frames(), o->request.seed)) {
        const int64_t at =
            std::min<int64_t>(clip.frames() - 1, std::llround(static_cast<double>(key) * rate / source.rate));
        if (o->request.keys.empty() || at > o->request.keys.back()) o->request.keys.push_back(at);
      }
      o->request.keys.back() = clip.frames() - 1;
    }
    if (!o->joints.empty()) o->request.given = given_groups(o->joints);
    const Clip poses = frames_at(clip, o->request.keys);
    Scene scene;
    if (o->scene.empty()) {
      scene = assumed_floor(poses);
      std::printf("no scene given: a flat floor under the feet is assumed\n");
    } else {
      scene = read_scene_file(o->scene).scene;
      scene.name = o->scene;  // named in errors
    }
    const CollisionMeter meter(builtin_body(), scene);
    const torch::Tensor colliding = meter.measure(poses).depth > 0;
    for (size_t k = 0; k < o->request.keys.size(); ++k)
      if (colliding[static_cast<int64_t>(k)].item<bool>())
        spdlog::warn("the key pose at {:.2f} s is inside the scene", static_cast<double>(o->request.keys[k]) / rate);
    o->request.progress = progress_lines("steps of the denoiser");
    const Clip filled = inbetweener.fill(clip, scene, o->request);
    for (const std::string& out : o->outputs) {
      if (std::filesystem::path(out).extension() == ".html") {
        Page page;
        page.title = "In-betweening of " + std::filesystem::path(o->motions[0]).filename().string();
        page.note = "Blue: key frames. Purple: filled in. Red: the body is inside the scene.";
        page.scene = &scene;
        PagePerson person{filled, "filled in", PagePerson::Role::filled};
        person.keys = o->request.keys;
        person.collides = meter.measure(filled).depth > 0;
        page.people.push_back(person);
        write_page(out, page);
      } else {
        write_clip(out, filled, &scene);
      }
      std::printf("%s\n", out.c_str());
    }
  });
}
