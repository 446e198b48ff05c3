// Forecasts of a person whose poses come in one at a time, as from a camera: stream MODEL MOTION SCENE
#include <inhabit/forecast/forecast_stream.h>
#include <inhabit/io/files.h>
#include <inhabit/io/scene_file.h>

#include <chrono>
#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  using inhabit::forecast::ContactForecaster;
  const auto forecaster = std::make_shared<const ContactForecaster>(ContactForecaster::load(argv[1]));
  const inhabit::Clip motion = inhabit::read_clip(argv[2]);  // whose frames are the poses that come in

  inhabit::forecast::StreamOptions options;
  options.poses.names = motion.skeleton.names;
  options.poses.parents = motion.skeleton.parents;
  options.poses.rate = 10;  // forecasts a second
  inhabit::forecast::ForecastStream stream(forecaster, inhabit::read_scene_file(argv[3]).scene, options);

  int forecasts = 0;
  double milliseconds = 0;
  for (int64_t frame = 0; frame < motion.frames(); ++frame) {
    stream.push("anna", static_cast<double>(frame) / motion.rate, motion.joints[frame]);
    const auto before = std::chrono::steady_clock::now();
    for (const inhabit::forecast::StreamResult& r : stream.take()) {  // none until a second was seen
      milliseconds += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before).count();
      if (!r.error.empty()) return std::fprintf(stderr, "%s\n", r.error.c_str()), 1;
      const torch::Tensor root = r.result.forecast.joints[-1][0];  // the last of 60 frames
      std::printf("%.2f s: two seconds later %s is at x %.2f m, z %.2f m\n", r.time, r.person.c_str(),
                  root[0].item<double>(), root[2].item<double>());
      ++forecasts;
    }
  }
  std::printf("stream: %d forecasts, each in %.1f ms\n", forecasts, milliseconds / forecasts);
}
