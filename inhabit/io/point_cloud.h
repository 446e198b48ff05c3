#pragma once
#include <torch/types.h>

#include <string>
#include <string_view>

#include "inhabit/io/npz.h"

namespace inhabit {

/// Points of a .ply, .pcd, .xyz (.txt, .pts, .csv) or .npz file, (N, 3) float in the file's own axes and units.
/// .pcd: ascii, binary, binary_compressed; points with a NaN, its mark for "not measured", are left out.
/// .xyz: three numbers or more to a line, of which the first three count, between spaces, tabs, commas or semicolons. A
/// decimal comma is understood where the line has another separator. '#' and '//' start a comment. A first line without
/// numbers is a heading; a first line with one whole number is a count.
/// .npz: the array `points`, `xyz` or `positions`, (N, 3) or wider; the first three columns count. .npy: its only
/// array. Throws Error(path, ...) when the file is missing, damaged, holds no point, or a NaN or infinite coordinate.
torch::Tensor read_point_cloud(const std::string& path);

/// The same from memory; `extension` ("pcd") tells the format.
torch::Tensor parse_point_cloud(std::string_view bytes, const std::string& extension, const std::string& subject);

/// True where a NumPy archive has an array that would be read as points.
bool holds_points(const Npz& npz);

}  // namespace inhabit
