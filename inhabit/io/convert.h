#pragma once
#include <map>
#include <string>
#include <vector>

#include "inhabit/io/read_options.h"
#include "inhabit/io/write_options.h"

namespace inhabit {

/// How a file becomes one of another format.
struct ConvertOptions {
  ClipReadOptions reading;  ///< of the input, `up` and `scale` of a scene too
  WriteOptions writing;     ///< of the output; +Y up unless z is asked for
  bool retarget = false;    ///< onto the standard 22 joints
  std::string scene;        ///< file of a scene that a .glb holds beside the motion; empty: none
  std::string body;         ///< SMPL, SMPL-H or SMPL-X model file (.npz) for motions of that family
};

/// Writes a motion or a scene in another format, told by the extensions (files.h, scene_file.h).
/// @param notes what was detected or assumed is added to it. @param written files that must not be written, by
/// their canonical paths, and what each was made of (nothing: it is an input), to which those of this call are added;
/// may be null. Returns one line for people that says what was written. Throws Error naming the file that cannot be
/// read or written, is among `written`, or that the options do not go with.
std::string convert_file(const std::string& in, const std::string& out, const ConvertOptions& options,
                         Notes* notes = nullptr, std::map<std::string, std::string>* written = nullptr);

/// A file to be converted, and what it becomes.
struct Conversion {
  std::string in;   ///< path of a file that is there
  std::string out;  ///< path of the one to be written
};

/// What convert_file makes of files, folders of motion and patterns (many_files.h) in the folder `out`: a file of the
/// same name with the extension `format`, below folders as it was. Of a folder, as ply its scenes; as glb those where
/// no motion is in it. The second of two that would become one file, and one that would be written over, are left out.
/// @param skipped why, a line for each, is added to it; may be null. @param inputs all files that are named are added
/// to it, for convert_file; may be null
std::vector<Conversion> conversions(const std::vector<std::string>& named, const std::string& out,
                                    const std::string& format, std::vector<std::string>* skipped = nullptr,
                                    std::map<std::string, std::string>* inputs = nullptr);

}  // namespace inhabit
