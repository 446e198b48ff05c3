#include "inputs.h"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/file_notes.h"
#include "inhabit/io/files.h"
#include "inhabit/motion/plausible.h"
#include "progress.h"
#include "verbs.h"

void add_scene_reading(CLI::App& verb, SceneInput& scene, CLI::Option* file) {
  add_up_axis(verb, scene.up, "--scene-up", "the scene");
  verb.get_option("--scene-up")->needs(file);
  verb.add_option("--scene-scale", scene.scale, "Metres per unit of the scene (default: detected)")
      ->check(positive_number)
      ->needs(file);
}

void add_scene(CLI::App& verb, SceneInput& scene, const std::string& otherwise) {
  add_scene_reading(verb, scene,
                    verb.add_option("--scene", scene.file, "Scene file: a mesh or a point cloud" + otherwise));
}

inhabit::Scene read_scene(const SceneInput& input, inhabit::Notes& notes) {
  if (input.file.empty()) return {};
  inhabit::SceneReadOptions options;
  options.up = input.up;
  if (input.scale > 0) options.scale = input.scale;
  inhabit::SceneFile read = inhabit::read_scene_file(input.file, options);
  if (read.report.up_detected || read.report.scale_detected)
    inhabit::add_notes(notes, {describe(read.report)}, input.file);
  read.scene.name = input.file;
  return std::move(read.scene);
}

void add_reading(CLI::App& verb, inhabit::ClipReadOptions& reading, const std::string& what) {
  add_up_axis(verb, reading.up, "--up", what);
  verb.add_option("--scale", reading.scale, "Metres per unit of " + what + " (default: detected)")
      ->check(positive_number);
  verb.add_option("--input-rate", reading.rate, "Frames a second of " + what + ", whatever its file says")
      ->check(frame_rate);
  verb.add_flag("--level", reading.level, "Make the floor under the feet of " + what + " level");
  verb.add_option("--asf", reading.asf, "Skeleton of an .amc (default: the .asf beside it)");
}

void add_reading_of(CLI::App& verb, inhabit::ClipReadOptions& reading, const std::string& name) {
  const std::string what = "--" + name;
  add_up_axis(verb, reading.up, what + "-up", what);
  verb.add_option(what + "-scale", reading.scale, "Metres per unit of " + what + " (default: detected)")
      ->check(positive_number);
  verb.add_option(what + "-input-rate", reading.rate, "Frames a second of " + what + ", whatever its files say")
      ->check(frame_rate);
}

void require_amc(const std::string& path, const inhabit::ClipReadOptions& reading) {
  if (!reading.asf.empty() && inhabit::extension_of(path) != "amc")
    throw inhabit::Error(path, "is no .amc, whose skeleton --asf is");
}

inhabit::Clip read_motion(const std::string& path, const inhabit::ClipReadOptions& reading, inhabit::Notes& notes) {
  require_amc(path, reading);
  inhabit::Notes own;
  inhabit::Clip clip = inhabit::read_clip(path, reading, &own);
  inhabit::add_notes(notes, std::move(own), path);
  return clip;
}

std::vector<inhabit::Clip> read_motions(const std::string& path, const inhabit::ClipReadOptions& reading,
                                        inhabit::Notes& notes) {
  require_amc(path, reading);
  inhabit::Notes own;
  std::vector<inhabit::Clip> clips = inhabit::read_samples(path, reading, &own);
  inhabit::add_notes(notes, std::move(own), path);
  return clips;
}

void say(const inhabit::Notes& all, size_t most) {
  inhabit::Notes notes;
  end_progress();
  for (const std::string& note : all)
    if (inhabit::is_doubt(note))
      std::fprintf(stderr, "inhabit: warning: %s\n", note.c_str());
    else
      notes.push_back(note);
  if (is_quiet()) return;
  for (size_t i = 0; i < std::min(most, notes.size()); ++i) std::printf("%s\n", notes[i].c_str());
  if (notes.size() > most) std::printf("and %zu more such notes\n", notes.size() - most);
}

void end_of(const inhabit::FileCount& count) {
  end_progress();
  if (count.skipped.empty()) return;
  for (const std::string& reason : count.skipped) std::fprintf(stderr, "inhabit: skipped: %s\n", reason.c_str());
  std::fprintf(stderr, "inhabit: %zu of %zu files were skipped\n", count.skipped.size(),
               count.skipped.size() + static_cast<size_t>(count.done));
  throw CLI::RuntimeError(1);
}

void add_shard(CLI::App& verb, std::string& shard) {
  verb.add_option("--shard", shard,
                  "I/N: only part I of N; all write into one folder, the last of them the index (docs/dataset.md)");
}

void add_evaluation_shard(CLI::App& verb, std::string& shard) {
  verb.add_option("--shard", shard,
                  "I/N: only part I of N, kept beside the --json file; the last one writes the table");
}

inhabit::MeasuredParts measured_parts(const CLI::App& verb, const std::string& shard, const std::string& json) {
  if (shard.empty()) return {};
  if (json.empty()) throw inhabit::Error("--shard", "needs --json: parts are kept beside the table");
  std::istringstream given(verb.config_to_str(/*default_also=*/true));
  std::string job;
  for (std::string line; std::getline(given, line);)
    if (line.rfind("shard=", 0) != 0) job += line + "\n";
  return {inhabit::parse_shard(shard), json, job};
}

std::string kept_of(const inhabit::MeasuredParts& parts) {
  if (!parts.shard().is_all())
    return "shard " + parts.shard().name() + " is to be measured again; others that were finished are kept";
  return "nothing was written; with --json FILE --shard I/N the parts that are finished are kept";
}

void say_part(const inhabit::MeasuredParts& parts) {
  end_progress();
  std::printf("shard %s is measured; the others are still to come\n", parts.shard().name().c_str());
}

inhabit::Shard shard_of(const std::string& given) {
  return given.empty() ? inhabit::Shard() : inhabit::parse_shard(given);
}
