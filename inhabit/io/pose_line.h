#pragma once
#include <torch/types.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace inhabit {

/// Which joints the lines after this one hold: {"names":["pelvis",...]}, with "parents" [-1, 0, ...] where the names
/// do not tell what hangs where.
struct JointNames {
  std::vector<std::string> names;  ///< in the order of the lines' rows
  std::vector<int> parents;        ///< empty: none are given
};

/// One person's joints at one time: {"time":12.3,"person":"anna","joints":[[x,y,z],...]}.
struct PoseLine {
  double time = 0;                ///< seconds
  std::string person = "person";  ///< a name of up to 64 bytes or a whole number; may be left out
  torch::Tensor joints;           ///< (J, 3) float32 metres; NaN where the line has null for a joint or a coordinate
};

/// What a line of a stream of poses holds.
using StreamLine = std::variant<PoseLine, JointNames>;

/// A line of a stream of poses (docs/robots.md). Throws Error("line", ...) for anything else: no JSON (as NaN is none),
/// other types, numbers that are not finite, joints beyond 10 km, over 1000 joints, names over 64 bytes.
StreamLine parse_stream_line(std::string_view text);

/// JSON nested arrays of (..., N) numbers to 0.1 mm: [[x,y,z],...]. Values that are not finite become null.
void append_places(std::string& text, const torch::Tensor& places);

}  // namespace inhabit
