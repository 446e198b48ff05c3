#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/forecast/forecast_clip.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/motion/transfer.h"
#include "inhabit/view/page.h"
#include "inputs.h"
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
  std::string model, keys, joints;
  ClipReadOptions reading;
  SceneInput scene;
  bool noisy = false, standard = false;
  InbetweenRequest request;
};

/// A clip at `rate` whose frames `keys`, the first being 0, are `poses`; the frames between, which nobody looks at,
/// repeat the pose before.
Clip clip_of_keys(const Clip& poses, const std::vector<int64_t>& keys, double rate) {
  std::vector<int64_t> held;
  for (size_t k = 0; k + 1 < keys.size(); ++k)
    held.insert(held.end(), static_cast<size_t>(keys[k + 1] - keys[k]), static_cast<int64_t>(k));
  held.push_back(static_cast<int64_t>(keys.size()) - 1);
  Clip out = frames_at(poses, held);
  out.rate = rate;
  return out;
}

/// One-pose files (of longer ones the first pose counts) at the times given.
Clip poses_at_times(const InbetweenArguments& o, double rate, std::vector<int64_t>& keys, SourcePoses& source,
                    Notes& notes) {
  if (o.times.size() != o.motions.size())
    throw Error("--times", "names " + std::to_string(o.times.size()) + " times for " +
                               std::to_string(o.motions.size()) + " files");
  std::vector<Clip> sources, poses;
  for (size_t i = 0; i < o.motions.size(); ++i) {
    const int64_t key = std::llround((o.times[i] - o.times[0]) * rate);
    if (i > 0 && key <= keys.back()) throw Error("--times", "are not in order, a frame or more apart");
    if (key > 100'000) throw Error("--times", "are more than 55 minutes apart");
    const Clip motion = read_motion(o.motions[i], o.reading, notes);
    sources.push_back(slice(motion, 0, 1));
    poses.push_back(slice(retarget(motion, o.motions[i]), 0, 1));
    const auto bones = [&](size_t k) { return poses[k].skeleton.offsets.slice(0, 1); };
    if ((bones(i) - bones(0)).abs().max().item<double>() > 0.02)
      throw Error(o.motions[i], "has other bones than " + o.motions[0]);
    keys.push_back(key);
    source.at.push_back(static_cast<double>(key));
    source.frames.push_back(std::llround((o.times[i] - o.times[0]) * sources[0].rate));
  }
  source.source = joined_poses(sources);
  source.standard = joined_poses(poses);
  return source.standard;
}

/// The poses in the frames of a file that --keyframes names, and at which frames they stand at `rate`: the nearest in
/// time; of several in one the first, but the file's last frame stands.
Clip poses_in_file(const InbetweenArguments& o, double rate, std::vector<int64_t>& keys, SourcePoses& poses,
                   Notes& notes) {
  const std::string& motion = o.motions[0];
  const Clip read = read_motion(motion, o.reading, notes), source = retarget(read, motion);
  std::vector<int64_t> frames, asked;
  try {
    asked = key_frames(o.keys, source.frames(), o.request.seed);
    for (const int64_t frame : asked) {
      const int64_t key = std::llround(static_cast<double>(frame) * rate / source.rate);
      if (!keys.empty() && key == keys.back()) {
        if (frame + 1 < source.frames() || keys.size() == 1) continue;
        keys.pop_back();
        frames.pop_back();
      }
      keys.push_back(key);
      frames.push_back(frame);
    }
  } catch (const Error& e) {
    throw Error(motion, e.what());
  }
  if (keys.size() < 2)
    throw Error(motion, fmt::format("is shorter than two frames of the model's, 1/{:g} s each", rate));
  poses = poses_of(read, source, asked, frames, keys);
  return frames_at(source, frames);
}

/// Which frames have the body inside the scene.
torch::Tensor colliding_frames(const CollisionMeter& meter, const Clip& clip) {
  constexpr int64_t kTogether = 60;
  const auto progress = progress_lines("frames looked at for collisions");
  std::vector<torch::Tensor> out;
  for (int64_t t = 0; t < clip.frames(); t += kTogether) {
    out.push_back(meter.measure(slice(clip, t, std::min(t + kTogether, clip.frames()))).depth > 0);
    progress(t, clip.frames());
  }
  return torch::cat(out);
}

/// Says which key poses are inside the scene: a warning, for in-betweening goes on.
void warn_of_collisions(const torch::Tensor& colliding, const std::vector<int64_t>& keys, double rate) {
  std::vector<std::string> times;
  for (size_t k = 0; k < keys.size(); ++k)
    if (colliding[static_cast<int64_t>(k)].item<bool>())
      times.push_back(fmt::format("{:.2f}", static_cast<double>(keys[k]) / rate));
  if (times.empty()) return;
  const size_t named = std::min<size_t>(times.size(), 5);
  std::fprintf(stderr, "inhabit: warning: %zu of %zu key poses are inside the scene, at %s%s s\n", times.size(),
               keys.size(),
               fmt::format("{}", fmt::join(times.begin(), times.begin() + static_cast<int64_t>(named), ", ")).c_str(),
               named < times.size() ? ", ..." : "");
}

}  // namespace

void add_inbetween(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("inbetween", "Fill in the motion between key frames, in a scene");
  auto o = std::make_shared<InbetweenArguments>();
  verb->add_option("motions", o->motions, "A motion file, or several at --times, whose first poses count")->required();
  add_reading(*verb, o->reading, "the motions");
  add_scene(*verb, o->scene, " (without one, a flat floor is assumed)");
  verb->add_option("--keyframes", o->keys,
                   "Frames of the file that are given: every:N, a list such as 0,30,95, random:P, or ends (default)")
      ->check(not_empty);
  verb->add_option("--times", o->times, "Seconds at which several files' poses stand")->delimiter(',');
  verb->add_option("--joints", o->joints,
                   "Joints that the keys between the ends give, such as pelvis,left_wrist; root is the root's path "
                   "(default: whole poses)")
      ->check(not_empty);
  verb->add_flag("--noisy", o->noisy, "Key frames are noisy: they are cleaned, but for the ends");
  verb->add_option("--model", o->model, "Model file (default: the one that ships)");
  add_sampler(*verb, o->request.sampler);
  verb->add_option("--steps", o->request.steps, "Evaluations of the denoiser")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--seed", o->request.seed, "Seed of the noise and of random key frames")
      ->check(whole_number)
      ->capture_default_str();
  verb->add_flag("!--loose-feet", o->request.clean_feet, "Leave feet as the network moves them");
  verb->add_flag("--standard", o->standard, "Write the standard 22 joints at 30 Hz, not the file's skeleton and rate");
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
    Notes notes;
    Clip clip;
    SourcePoses source;
    if (o->motions.size() > 1) {
      if (!o->keys.empty()) throw Error("--keyframes", "is for one file; several stand at --times");
      clip = clip_of_keys(poses_at_times(*o, rate, o->request.keys, source, notes), o->request.keys, rate);
    } else {
      if (!o->times.empty()) throw Error("--times", "is for several files; one has --keyframes");
      if (o->keys.empty()) o->keys = "ends";
      clip = clip_of_keys(poses_in_file(*o, rate, o->request.keys, source, notes), o->request.keys, rate);
    }
    if (!o->joints.empty()) o->request.given = given_groups(o->joints);
    const Clip poses = frames_at(clip, o->request.keys);
    Scene scene;
    if (o->scene.file.empty()) {
      scene = assumed_floor(poses);
      notes.emplace_back("no scene given: a flat floor under the feet is assumed");
    } else {
      scene = read_scene(o->scene, notes);
    }
    const CollisionMeter meter(builtin_body(), scene);
    warn_of_collisions(meter.measure(poses).depth > 0, o->request.keys, rate);
    if (scene.meshes.empty())
      notes.push_back(o->scene.file + ": is a point cloud: where a body is inside it cannot be told");
    o->request.progress = progress_lines("steps of the denoiser");
    const Clip filled = inbetweener.fill(clip, scene, o->request);
    if (source.source.frames() == 0)
      notes.emplace_back("the files hold no rotations on one skeleton: written on the standard one");
    // Noisy keys are cleaned and partial ones leave joints open, but for the ends.
    source.exact.assign(source.frames.size(), inbetweener.config().t_star == 0 && !o->request.given.defined());
    source.exact.front() = source.exact.back() = true;
    const Clip written = o->standard || source.source.frames() == 0
                             ? filled
                             : on_source_skeleton(filled, source, source.frames.back() + 1);
    say(notes);
    for (const std::string& out : o->outputs) {
      if (extension_of(out) == "html") {
        Page page;
        page.title = "In-betweening of " + std::filesystem::path(o->motions[0]).filename().string();
        page.note = std::string("Blue: what was given. Purple: filled in. Prints on the floor: where a foot stands. ") +
                    (scene.meshes.empty() ? "The scene is points, which have no inside."
                                          : "Red: the body is inside the scene.");
        page.scene = &scene;
        PagePerson person{filled, "filled in", PagePerson::Role::filled};
        person.keys = o->request.keys;
        if (o->noisy || o->request.given.defined()) person.given = poses;
        person.given_joints = given_joints(o->request.given);
        person.collides = colliding_frames(meter, filled);
        page.people.push_back(person);
        write_page(out, page);
      } else {
        write_clip(out, written, &scene);
      }
      std::printf("%s\n", out.c_str());
    }
  });
}
