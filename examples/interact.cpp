// A person walks up to an armchair and sits down, hands where ContactNet puts them: interact MODEL SCENE OUT
#include <inhabit/interact/chair_interactor.h>
#include <inhabit/io/files.h>
#include <inhabit/io/scene_file.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const auto interactor = inhabit::interact::ChairInteractor::load(argv[1]);
  const inhabit::Scene scene = inhabit::read_scene_file(argv[2]).scene;

  inhabit::interact::Options options;
  options.chair = "armchair_0";
  options.draw_contacts = true;
  options.seconds = 12;
  const inhabit::Clip start = inhabit::interact::standing_clip({0, 1}, /*heading=*/1.57);
  const inhabit::interact::Result result = interactor.run(start, scene, options);
  inhabit::write_clip(argv[3], result.motion);

  std::printf("interact: %lld frames, %s\n", static_cast<long long>(result.motion.frames()),
              result.seated ? "seated in the end" : "not seated");
}
