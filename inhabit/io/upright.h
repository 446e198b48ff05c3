#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>

#include "inhabit/io/read_options.h"
#include "inhabit/motion/clip.h"

namespace inhabit {

/// Where a person's back points on average, from pelvis to head, as the mean of unit vectors; none where
/// find_landmarks does not know the skeleton.
std::optional<Eigen::Vector3d> mean_trunk(const Clip& clip);

/// Whether a motion is to be rotated from +Z up. As `told`; throws Error(subject, ...) for one told to be z-up whose
/// trunk points along +Y, for it would come out lying. Left automatic, it is where the trunk points along +Z and the
/// lowest joint is nearer to 0 along Z than along Y (someone who lies on a floor y = 0 lies). What was detected, or
/// looks wrong, is added to the notes.
bool is_z_up(const Clip& clip, UpAxis told, const std::string& subject, Notes* notes);

/// Throws as is_z_up does where `told` is z and the trunk points along +Y; notes a trunk along +Z where it is y.
void check_told_up(const std::optional<Eigen::Vector3d>& trunk, UpAxis told, const std::string& subject, Notes* notes);

/// Rotates a clip of a z-up world to +Y up, by -90 degrees about x: (x, y, z) -> (x, z, -y), with all that is
/// annotated.
void rotate_upright(Clip& clip);

/// Back again: (x, y, z) -> (x, -z, y).
void rotate_z_up(Clip& clip);

}  // namespace inhabit
