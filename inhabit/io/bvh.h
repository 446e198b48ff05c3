#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "inhabit/io/source_motion.h"

namespace inhabit {

/// Reads a Biovision hierarchy (.bvh). Any order of channels; joints with 1, 2, 3 or 6 channels. Position channels of a
/// joint stand in place of its OFFSET, as Blender and MotionBuilder read them. Each End Site becomes a leaf joint
/// called PARENT_end. Up stays the file's +Y. clip.skeleton is in metres; where joints other than the root carry
/// positions, its offsets are their median, and clip.translations what they are where that is not the same throughout.
/// A root that stands while a joint below it carries the body is as the file has it (motion/locomotion.h).
/// @param metres_per_unit empty: guessed from the size of the person (guess_length_unit of the bones below the joint
/// that legs and spine hang on), and said in the notes.
/// Throws Error with file and line: no hierarchy, unbalanced braces, unknown channels, a frame time outside
/// [0.001, 10] s, decimal commas, numbers that are not finite, fewer numbers than frames times channels, no frames.
SourceMotion read_bvh(const std::string& path, std::optional<double> metres_per_unit = {});
/// As read_bvh, from a file's text.
/// @param name names it in errors
SourceMotion parse_bvh(std::string_view text, const std::string& name, std::optional<double> metres_per_unit = {});

/// Writes clip.rotations, clip.trans and clip.translations on clip.skeleton, in centimetres and degrees: the unit of
/// Unreal, MotionBuilder and most published BVH (in Blender's importer give a scale of 0.01). Channels are Xposition
/// Yposition Zposition Zrotation Yrotation Xrotation for the root and for joints that translate, the three rotations
/// for every other joint; joints that were End Sites are End Sites again, other leaves get one of 5 cm. Euler angles
/// are unwrapped, so that curves between frames stay short. Where clip.file is of a .bvh, its unit, up axis, names,
/// channels and the joint that carried the body stay as they were there.
/// @param units_per_metre 100 for centimetres; not used where clip.file knows the unit. Throws Error where the clip has
/// no rotations (fit a body first), or where the file cannot be written.
void write_bvh(const std::string& path, const Clip& clip, double units_per_metre = 100);

}  // namespace inhabit
