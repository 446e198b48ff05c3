// Five futures of ten seconds of a motion: anticipate MODEL MOTION OUT
#include <inhabit/anticipate/intention_anticipator.h>
#include <inhabit/io/clip_npz.h>
#include <inhabit/io/files.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const auto anticipator = inhabit::anticipate::IntentionAnticipator::load(argv[1]);
  const inhabit::Clip motion = inhabit::read_clip(argv[2]);

  inhabit::anticipate::Options options;
  options.samples = 5;
  options.seconds = 10;
  const inhabit::anticipate::Result result = anticipator.run(motion, {}, options);
  inhabit::write_clips_npz(argv[3], result.on_source, {{"intention", result.labels_on_source}});

  for (size_t i = 0; i < result.futures.size(); ++i) {
    const torch::Tensor path = result.futures[i].root_path();
    std::printf("future %zu: the root ends %.1f m from where it began\n", i,
                (path[-1] - path[0]).norm().item<double>());
  }
}
