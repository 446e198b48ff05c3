// The next two seconds of a person's motion in a room: forecast MODEL MOTION SCENE OUT
#include <inhabit/forecast/contact_forecaster.h>
#include <inhabit/io/files.h>
#include <inhabit/io/scene_file.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  const auto forecaster = inhabit::forecast::ContactForecaster::load(argv[1]);
  const inhabit::Clip motion = inhabit::read_clip(argv[2]);
  const inhabit::Scene scene = inhabit::read_scene_file(argv[3]).scene;

  inhabit::forecast::Options options;
  options.start = motion.frames() / 2;  // the second before this frame is observed
  const inhabit::forecast::Result result = forecaster.run(motion, scene, options);
  inhabit::write_clip(argv[4], result.on_source);

  const torch::Tensor touching = result.forecast.contact_points.select(2, 3).mean(0);
  std::printf("forecast: %lld frames, left foot in contact in %.0f %% of them\n",
              static_cast<long long>(result.prediction.frames()), 100 * touching[10].item<double>());
}
