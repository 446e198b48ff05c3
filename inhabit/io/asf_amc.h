#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "inhabit/io/source_motion.h"

namespace inhabit {

// Acclaim's pair of files: .asf describes the skeleton, .amc the motion. Each bone becomes a joint at its start, called
// as the bone; a bone without children gets a leaf joint <bone>_end at its tip. Local rotations are C M C^-1 (C the
// bone's axis, M its degrees of freedom), so that all joint frames are parallel to the world's at rest.

/// Reads a motion on its skeleton. Bones with degrees of freedom tx ty tz translate, along their own axes; `l` is left
/// out. An .amc does not say its rate: 120 Hz, as nearly all of CMU's, unless the file does.
/// @param asf_path empty: find_asf(amc_path). @param metres_per_unit empty: 0.0254 / `length` of the .asf (CMU's 0.45
/// makes 0.0564444 m) where that makes the size of a person, otherwise guessed from it, and said in the notes.
/// Throws Error with file and line: unknown bones, a hierarchy that is no tree, missing or superfluous numbers, numbers
/// that are not finite, a frame that lacks a bone, no frames.
SourceMotion read_asf_amc(const std::string& amc_path, const std::string& asf_path = "",
                          std::optional<double> metres_per_unit = {});
/// As read_asf_amc, from the texts of both files.
/// @param asf_name, amc_name name them in errors
SourceMotion parse_asf_amc(std::string_view asf, const std::string& asf_name, std::string_view amc,
                           const std::string& amc_name, std::optional<double> metres_per_unit = {});

/// The .asf that belongs to an .amc: of the same name, or of the subject's prefix (02_01.amc -> 02.asf), or the only
/// one in the folder. Throws Error where there is none or no telling which.
std::string find_asf(const std::string& amc_path);

}  // namespace inhabit
