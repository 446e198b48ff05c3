#pragma once
#include <functional>

#include "polygonise.h"

namespace inhabit {

/// Collapses edges of least quadric error (Garland and Heckbert 1997) until at most `vertices` are left or none can go.
/// The topology stays: no edge ends up with three faces, nothing folds over, and an open edge in the plane x = 0 stays
/// there, so that the two mirrored halves meet.
/// @param importance error at a place counts this many times; above 1 keeps more detail there.
TriangleSurface decimate(const TriangleSurface& surface, size_t vertices,
                         const std::function<double(const Eigen::Vector3d&)>& importance);

}  // namespace inhabit
