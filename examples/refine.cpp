// A noisy motion made clean, feet in place: refine MOTION SCENE OUT
#include <inhabit/io/files.h>
#include <inhabit/io/scene_file.h>
#include <inhabit/refine/refine_clip.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const inhabit::Clip motion = inhabit::read_clip(argv[1]);
  const inhabit::Scene scene = inhabit::read_scene_file(argv[2]).scene;

  inhabit::refine::Options options;
  options.keep_frames = {0, motion.frames() - 1};  // the ends stay as they are
  const inhabit::refine::Result result = inhabit::refine::refine(motion, scene, options);
  inhabit::write_clip(argv[3], result.on_source);

  std::printf("refine: %lld contacts, joints moved by %.1f mm in the mean\n", static_cast<long long>(result.contacts),
              1000 * result.moved);
}
