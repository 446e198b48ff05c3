// A motion on any skeleton brought to the standard 22 joints and 30 frames a second: retarget MOTION OUT
#include <inhabit/io/files.h>
#include <inhabit/motion/resample.h>
#include <inhabit/motion/retarget.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  inhabit::ClipReadOptions reading;
  inhabit::Notes notes;  // what was detected of units and axes
  const inhabit::Clip source = inhabit::read_clip(argv[1], reading, &notes);
  const inhabit::Clip standard = inhabit::resample(inhabit::retarget(source, argv[1]), 30);
  inhabit::write_clip(argv[2], standard);

  for (const std::string& note : notes) std::printf("%s\n", note.c_str());
  std::printf("%lld joints at %g Hz became %lld at %g Hz\n", static_cast<long long>(source.skeleton.size()),
              source.rate, static_cast<long long>(standard.skeleton.size()), standard.rate);
}
