#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "inhabit/data/measured_parts.h"
#include "inhabit/data/shard.h"
#include "inhabit/io/many_files.h"
#include "inhabit/io/read_options.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/motion/clip.h"

/// A scene file and how a verb's user wants it understood.
struct SceneInput {
  std::string file;  ///< empty: none is given
  inhabit::UpAxis up = inhabit::UpAxis::automatic;
  double scale = 0;  ///< metres per unit; 0: detected
};

/// Adds --scene-up and --scene-scale for the scene that `file` names.
void add_scene_reading(CLI::App& verb, SceneInput& scene, CLI::Option* file);

/// Adds --scene, --scene-up and --scene-scale. @param otherwise what happens without a scene, in brackets, or nothing
void add_scene(CLI::App& verb, SceneInput& scene, const std::string& otherwise = "");

/// The scene, named after its file; an empty one where none is given. @param notes what was detected of axes and units
/// is added to it
inhabit::Scene read_scene(const SceneInput& scene, inhabit::Notes& notes);

/// Adds --up, --scale, --input-rate, --level and --asf: how a verb's user wants its motion files understood.
void add_reading(CLI::App& verb, inhabit::ClipReadOptions& reading, const std::string& what = "the motion");

/// The same for a second kind of files, of which the format is all that may be open: --NAME-up, --NAME-scale and
/// --NAME-input-rate.
void add_reading_of(CLI::App& verb, inhabit::ClipReadOptions& reading, const std::string& name);

/// Throws inhabit::Error where --asf is given with a file that is no .amc.
void require_amc(const std::string& path, const inhabit::ClipReadOptions& reading);

/// The motion in a file; throws what require_amc throws. @param notes what was detected and assumed is added to it
inhabit::Clip read_motion(const std::string& path, const inhabit::ClipReadOptions& reading, inhabit::Notes& notes);
/// All futures of an .npz; of other files the first motion, as others may be of other skeletons and lengths.
std::vector<inhabit::Clip> read_motions(const std::string& path, const inhabit::ClipReadOptions& reading,
                                        inhabit::Notes& notes);

/// Prints notes, a line each: once nothing can be refused any more. Doubts (motion/plausible.h) come first, all of
/// them, on stderr and with --quiet too. @param most of many files' other notes only so many
void say(const inhabit::Notes& notes, size_t most = SIZE_MAX);

/// The end of a verb of many files: where some were skipped, says which and why on stderr and ends with exit code 1.
void end_of(const inhabit::FileCount& count);

/// --shard I/N of a big job.
void add_shard(CLI::App& verb, std::string& shard);
/// All of it where none is given.
inhabit::Shard shard_of(const std::string& given);

/// --shard I/N of an evaluation.
void add_evaluation_shard(CLI::App& verb, std::string& shard);
/// The part of an evaluation that is asked for, once options are parsed. @param json where its table goes
inhabit::MeasuredParts measured_parts(const CLI::App& verb, const std::string& shard, const std::string& json);
/// What is said of an evaluation that is interrupted (GoesOnLater).
std::string kept_of(const inhabit::MeasuredParts& parts);

/// Says that a part is measured and others are still to come.
void say_part(const inhabit::MeasuredParts& parts);
