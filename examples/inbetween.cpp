// The motion between key frames in a room: inbetween MODEL MOTION SCENE OUT
#include <inhabit/inbetween/keyframes.h>
#include <inhabit/inbetween/scene_inbetweener.h>
#include <inhabit/io/files.h>
#include <inhabit/io/scene_file.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  const auto inbetweener = inhabit::inbetween::SceneInbetweener::load(argv[1]);
  const inhabit::Clip motion = inhabit::read_clip(argv[2]);
  const inhabit::Scene scene = inhabit::read_scene_file(argv[3]).scene;

  inhabit::inbetween::Options options;
  options.keys = inhabit::inbetween::key_frames("every:45", motion.frames());
  options.collisions = true;
  const inhabit::inbetween::Result result = inbetweener.run(motion, scene, options);
  inhabit::write_clip(argv[4], result.on_source);

  std::printf("inbetween: %zu key frames, %lld of %lld frames with the body inside the scene\n", result.keys.size(),
              static_cast<long long>(result.collides.sum().item<int64_t>()),
              static_cast<long long>(result.motion.frames()));
}
