#include "inhabit/io/convert.h"

#include <cstdio>
#include <memory>

#include "inputs.h"
#include "verbs.h"

void add_convert(CLI::App& app) {
  struct Convert {
    std::string in, out;
    inhabit::ConvertOptions options;
  };
  CLI::App* verb = app.add_subcommand("convert", "Write a motion or a scene in another format");
  auto given = std::make_shared<Convert>();
  verb->add_option(
          "IN", given->in,
          "Motion (.bvh .amc .txt .npz .npy .json) or scene (.obj .ply .glb .gltf .off .stl .pcd .xyz .npz .npy)")
      ->required();
  verb->add_option("OUT", given->out, "Motion: .npz .json .bvh .glb; scene: .glb .ply")->required();
  verb->add_option("--rate", given->options.rate, "Frames a second of the output")->check(frame_rate);
  verb->add_flag("--retarget", given->options.retarget, "Onto the standard 22 joints");
  add_reading(*verb, given->options.reading, "the input");
  verb->add_option("--out-up", given->options.up, "Up axis of the output, y (default) or z (.bvh, .npz)")
      ->transform(one_of<inhabit::UpAxis>({{"y", inhabit::UpAxis::y}, {"z", inhabit::UpAxis::z}}))
      ->option_text("y|z");
  verb->add_option("--scene", given->options.scene, "Scene to put into a .glb beside the motion");
  verb->add_option("--body", given->options.body,
                   "SMPL, SMPL-H or SMPL-X model file (.npz) for motions of that family");
  verb->callback([given] {
    inhabit::Notes notes;
    const std::string written = inhabit::convert_file(given->in, given->out, given->options, &notes);
    for (const std::string& note : notes) std::printf("%s: %s\n", given->in.c_str(), note.c_str());
    std::printf("%s: %s\n", given->out.c_str(), written.c_str());
  });
}
