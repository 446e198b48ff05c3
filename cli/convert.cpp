#include <cstdio>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/smpl_model.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inputs.h"
#include "verbs.h"

namespace {

struct Convert {
  std::string in, out, scene, body;
  inhabit::UpAxis out_up = inhabit::UpAxis::y;
  inhabit::ClipReadOptions reading;
  double rate = 0;
  bool retarget = false;
};

void convert_motion(const Convert& given) {
  using namespace inhabit;
  ClipReadOptions options = given.reading;
  BodyModel body;
  if (!given.body.empty()) {
    body = read_smpl_model(given.body);
    options.body = &body;
  }
  Notes notes;
  Clip clip = read_clip(given.in, options, &notes);
  clip.file = {};
  if (given.out_up == UpAxis::z) {
    clip.file.format = extension_of(given.out);
    if (clip.file.format != "bvh" && clip.file.format != "npz")
      throw Error(given.out, "is +Y up by its format; --out-up z is for .bvh and .npz");
    clip.file.metres_per_unit = 0.01;
    clip.file.z_up = true;
  }
  if (given.retarget) {
    const FileConventions file = clip.file;
    clip = retarget(clip, given.in);
    clip.file = file;
  }
  if (given.rate > 0) clip = resample(clip, given.rate, given.in);
  SceneFile scene;
  if (!given.scene.empty()) {
    if (extension_of(given.out) != "glb") throw Error(given.out, "only .glb holds a scene beside the motion");
    scene = read_scene_file(given.scene);
  }
  write_clip(given.out, clip, given.scene.empty() ? nullptr : &scene.scene);
  for (const std::string& note : notes) std::printf("%s: %s\n", given.in.c_str(), note.c_str());
  std::printf("%s: %lld frames at %g a second (%.2f s), %d joints\n", given.out.c_str(),
              static_cast<long long>(clip.frames()), clip.rate, clip.seconds(), clip.skeleton.size());
}

void convert_scene(const Convert& given) {
  using namespace inhabit;
  SceneReadOptions options;
  options.up = given.reading.up;
  if (given.reading.scale > 0) options.scale = given.reading.scale;
  if (given.rate > 0 || given.reading.rate > 0 || !given.reading.asf.empty() || given.retarget ||
      !given.scene.empty() || !given.body.empty() || given.out_up == UpAxis::z)
    throw Error(given.in, "is a scene: frame rates, --asf, --retarget, --scene, --out-up and --body go with motions");
  const SceneFile file = read_scene_file(given.in, options);
  write_scene(given.out, file.scene);
  std::printf("%s: %s\n", given.out.c_str(), describe(file.report).c_str());
}

}  // namespace

void add_convert(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("convert", "Write a motion or a scene in another format");
  auto given = std::make_shared<Convert>();
  verb->add_option(
          "IN", given->in,
          "Motion (.bvh .amc .txt .npz .npy .json) or scene (.obj .ply .glb .gltf .off .stl .pcd .xyz .npz .npy)")
      ->required();
  verb->add_option("OUT", given->out, "Motion: .npz .json .bvh .glb; scene: .glb .ply")->required();
  verb->add_option("--rate", given->rate, "Frames a second of the output")->check(frame_rate);
  verb->add_flag("--retarget", given->retarget, "Onto the standard 22 joints");
  add_reading(*verb, given->reading, "the input");
  verb->add_option("--out-up", given->out_up, "Up axis of the output, y (default) or z (.bvh, .npz)")
      ->transform(one_of<inhabit::UpAxis>({{"y", inhabit::UpAxis::y}, {"z", inhabit::UpAxis::z}}))
      ->option_text("y|z");
  verb->add_option("--scene", given->scene, "Scene to put into a .glb beside the motion");
  verb->add_option("--body", given->body, "SMPL, SMPL-H or SMPL-X model file (.npz) for motions of that family");
  verb->callback([given] {
    const std::string extension = inhabit::extension_of(given->in);
    const bool is_motion = inhabit::is_clip_file(given->in) || !inhabit::is_scene_extension(extension);
    if (is_motion)
      convert_motion(*given);
    else
      convert_scene(*given);
  });
}
