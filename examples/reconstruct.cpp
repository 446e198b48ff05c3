// A person's motion and the room around them, from what networks made of a video: reconstruct MODEL FOLDER OUT
// FOLDER is laid out as `inhabit eval reconstruct --keep FOLDER` writes it.
#include <inhabit/io/files.h>
#include <inhabit/reconstruct/input_files.h>
#include <inhabit/reconstruct/reconstruct.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const auto inbetweener = inhabit::inbetween::SceneInbetweener::load(argv[1]);
  const std::string folder = argv[2];

  inhabit::reconstruct::InputFiles files;
  files.motion = folder + "/estimated.npz";
  files.camera = folder + "/camera.json";
  files.depth = {folder + "/depth_*.npy"};
  files.masks = {folder + "/mask_*.png"};
  inhabit::ClipReadOptions reading;
  reading.up = inhabit::UpAxis::y;  // the camera's file tells where gravity is
  const inhabit::reconstruct::Inputs inputs = inhabit::reconstruct::open_inputs(files, reading, nullptr);

  const inhabit::reconstruct::Result result = inhabit::reconstruct::run(inputs, inbetweener);
  inhabit::write_clip(argv[3], result.on_source);

  std::printf("reconstruct: %lld frames, depth is %.2f x + %.2f m, the floor is at %.2f m\n",
              static_cast<long long>(result.motion.frames()), result.depth.scale.scale, result.depth.scale.offset,
              result.floor);
}
