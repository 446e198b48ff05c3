#include <spdlog/fmt/fmt.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "inhabit/io/files.h"
#include "inhabit/io/smpl_model.h"
#include "inhabit/refine/refine_clip.h"
#include "inhabit/refine/refine_depth.h"
#include "inhabit/view/refined_page.h"
#include "inputs.h"
#include "outputs.h"
#include "progress.h"
#include "verbs.h"

namespace {

struct RefineArguments {
  std::string motion, keep, contacts = "auto";
  bool standard = false, generated = false;
  double smooth = 1;
  inhabit::ClipReadOptions reading;
  SceneInput scene;
  inhabit::WriteOptions writing;
  std::vector<std::string> outputs;
  std::string depth, body;
  double depth_scale = 1;
  std::vector<double> camera;
};

/// Motions as they were and as they are refined; `written`, on the skeleton that is asked for, go to files.
void write_refined(const RefineArguments& o, const std::vector<inhabit::RefinedPerson>& people,
                   const std::vector<inhabit::Clip>& written, const inhabit::Scene& scene) {
  using namespace inhabit;
  write_outputs(
      o.outputs,
      [&] { return refined_page(people, scene, "Refined: " + std::filesystem::path(o.motion).filename().string()); },
      [&](const std::string& out) {
        write_clips(out, written, o.writing, {}, &scene);
        return written.size();
      });
}

void run_on_depth(const RefineArguments& o) {
  using namespace inhabit;
  Notes notes;
  BodyModel body;
  ClipReadOptions reading = o.reading;
  if (!o.body.empty()) {
    body = read_smpl_model(o.body);
    reading.body = &body;
  }
  if (!o.scene.file.empty())
    notes.push_back(o.scene.file + ": is shown; a motion that is fitted to depth is held by what the camera saw alone");
  const Clip clip = read_motion(o.motion, reading, notes);
  const Scene scene = read_scene(o.scene, notes);
  // The clouds' axes are those of the motion's file.
  const bool z_up = clip.file.z_up;
  const CloudSequence clouds = open_clouds(o.depth, {o.depth_scale, z_up});
  refine::DepthOptions options;
  if (!o.body.empty()) options.body = &body;
  options.smooth = o.smooth;
  options.name = o.motion;
  options.standard = o.standard;
  if (!o.camera.empty()) {
    const Eigen::Vector3d at = o.depth_scale * Eigen::Vector3d(o.camera[0], o.camera[1], o.camera[2]);
    options.camera = z_up ? Eigen::Vector3d(at.x(), at.z(), -at.y()) : at;
  }
  const refine::DepthResult result = refine::refine_to_depth(clip, clouds, options);
  say(notes);
  std::printf("points %.1f mm from the skin before, %.1f mm after; joints moved by %.1f mm in the mean\n",
              1e3 * result.distance_before, 1e3 * result.distance_after, 1e3 * result.moved);
  write_refined(o, {{result.before, result.clip}}, {o.standard ? result.clip : result.on_source}, scene);
}

void run_on_motion(const RefineArguments& o) {
  using namespace inhabit;
  Notes notes;
  const std::vector<Clip> clips = read_motions(o.motion, o.reading, notes);
  const Scene scene = read_scene(o.scene, notes);
  std::vector<RefinedPerson> people;
  std::vector<Clip> written;
  std::string said;
  for (const Clip& clip : clips) {
    refine::Options options;
    options.contacts = o.contacts != "none";
    options.hands = o.contacts == "auto";
    options.generated = o.generated;
    options.smooth = o.smooth;
    refine::add_kept(o.keep, clip, options);
    options.name = o.motion;
    options.standard = o.standard;
    options.progress = progress_of("stretches");
    const refine::Result result = refine::refine(clip, scene, options);
    said += fmt::format(
        "noise of {:.1f} degrees and {:.1f} mm found, {} contacts of feet, {} of hands; joints moved by "
        "{:.1f} mm in the mean\n",
        57.29578 * result.noise_rotations, 1e3 * result.noise_root, result.contacts, result.hands.size(),
        1e3 * result.moved);
    people.push_back({result.before, result.clip});
    written.push_back(o.standard ? result.clip : result.on_source);
  }
  say(notes);
  std::printf("%s", said.c_str());
  write_refined(o, people, written, scene);
}

}  // namespace

void add_refine(CLI::App& app) {
  CLI::App* verb = app.add_subcommand(
      "refine", "Clean a motion: smooth as far as it is noisy, feet in place, nobody inside the scene");
  auto o = std::make_shared<RefineArguments>();
  verb->add_option("motion", o->motion, "Motion file: a recording or what a network made")->required();
  add_reading(*verb, o->reading);
  add_scene(*verb, o->scene, " (without one, a flat floor is assumed)");
  verb->add_option("--contacts", o->contacts,
                   "auto: feet stay where they are found to stand, hands where they rest on the scene; feet: these "
                   "alone; none: both are left alone")
      ->check(CLI::IsMember({"auto", "feet", "none"}))
      ->option_text("auto|feet|none [auto]");
  verb->add_option(
      "--keep", o->keep,
      "What stays as it is, between commas: frames (0,60,90), every:N, joints by their standard names or the file's");
  CLI::Option* generated =
      verb->add_flag("--generated", o->generated,
                     "A network made the motion: feet that glide a little are taken for standing, poses are believed "
                     "less closely");
  verb->add_option("--smooth", o->smooth, "Factor on the smoothing; 0: none")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  CLI::Option* depth =
      verb->add_option("--depth", o->depth,
                       "Fit the motion to what a depth camera saw of the person instead: a folder with a point cloud a "
                       "frame, or an .npz with points (T, N, 3), in the world of the motion's file");
  verb->add_option("--body", o->body, "SMPL, SMPL-H or SMPL-X model file (.npz) of who was seen (default: built in)")
      ->needs(depth);
  verb->add_option("--camera", o->camera,
                   "Where the depth camera stands, x,y,z as the points: skin that it sees is pulled to them too")
      ->expected(3)
      ->delimiter(',')
      ->needs(depth);
  verb->add_option("--depth-scale", o->depth_scale, "Metres per unit of the points (0.001: millimetres)")
      ->check(positive_number)
      ->needs(depth)
      ->capture_default_str();
  depth->excludes("--contacts", "--keep")->excludes(generated);
  verb->add_flag("--standard", o->standard, "Write the standard 22 joints, not the file's skeleton");
  add_writing(*verb, o->writing);
  add_outputs(*verb, o->outputs,
              "Output files: .npz .bvh .glb .json hold the motion, .html is a page with both (default: refined.html)");
  verb->callback([o] {
    using namespace inhabit;
    require_motion_outputs(o->outputs, "refined.html", "a refined motion");
    require_motion_written(o->writing, o->outputs);
    o->standard |= pages_alone(o->outputs);
    if (!o->depth.empty()) return run_on_depth(*o);
    run_on_motion(*o);
  });
}
