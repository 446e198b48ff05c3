#include "inhabit/io/convert.h"

#include <spdlog/fmt/fmt.h>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/smpl_model.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"

namespace inhabit {
namespace {

std::string convert_motion(const std::string& in, const std::string& out, const ConvertOptions& given, Notes* notes) {
  ClipReadOptions options = given.reading;
  BodyModel body;
  if (!given.body.empty()) {
    body = read_smpl_model(given.body);
    options.body = &body;
  }
  Clip clip = read_clip(in, options, notes);
  clip.file = {};
  if (given.up == UpAxis::z) {
    clip.file.format = extension_of(out);
    if (clip.file.format != "bvh" && clip.file.format != "npz")
      throw Error(out, "is +Y up by its format; --out-up z is for .bvh and .npz");
    clip.file.metres_per_unit = 0.01;
    clip.file.z_up = true;
  }
  if (given.retarget) {
    const FileConventions file = clip.file;
    clip = retarget(clip, in);
    clip.file = file;
  }
  if (given.rate > 0) clip = resample(clip, given.rate, in);
  SceneFile scene;
  if (!given.scene.empty()) {
    if (extension_of(out) != "glb") throw Error(out, "only .glb holds a scene beside the motion");
    scene = read_scene_file(given.scene);
  }
  write_clip(out, clip, given.scene.empty() ? nullptr : &scene.scene);
  return fmt::format("{} frames at {:g} a second ({:.2f} s), {} joints", clip.frames(), clip.rate, clip.seconds(),
                     clip.skeleton.size());
}

std::string convert_scene(const std::string& in, const std::string& out, const ConvertOptions& given) {
  SceneReadOptions options;
  options.up = given.reading.up;
  if (given.reading.scale > 0) options.scale = given.reading.scale;
  if (given.rate > 0 || given.reading.rate > 0 || !given.reading.asf.empty() || given.retarget ||
      !given.scene.empty() || !given.body.empty() || given.up == UpAxis::z)
    throw Error(in, "is a scene: frame rates, --asf, --retarget, --scene, --out-up and --body go with motions");
  const SceneFile file = read_scene_file(in, options);
  write_scene(out, file.scene);
  return describe(file.report);
}

}  // namespace

std::string convert_file(const std::string& in, const std::string& out, const ConvertOptions& options, Notes* notes) {
  const bool is_motion = is_clip_file(in) || !is_scene_extension(extension_of(in));
  return is_motion ? convert_motion(in, out, options, notes) : convert_scene(in, out, options);
}

}  // namespace inhabit
