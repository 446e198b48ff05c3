#include "inhabit/io/stl.h"

#include <cstring>
#include <numeric>

#include "inhabit/error.h"
#include "inhabit/io/number_text.h"
#include "inhabit/io/weld.h"

namespace inhabit {
namespace {

std::vector<float> binary_corners(std::string_view bytes, uint32_t triangles, const std::string& subject) {
  std::vector<float> corners(9UL * triangles);
  for (size_t i = 0; i < triangles; ++i) {
    std::memcpy(corners.data() + 9 * i, bytes.data() + 84 + 50 * i + 12, 36);
    for (size_t k = 9 * i; k < 9 * i + 9; ++k) {
      if (!std::isfinite(corners[k])) throw Error(subject, "triangle " + std::to_string(i) + " is not finite");
    }
  }
  return corners;
}

std::vector<float> ascii_corners(std::string_view text, const std::string& subject) {
  std::vector<float> corners;
  size_t in_face = 0;
  for (int64_t number = 1; !text.empty(); ++number) {
    std::string_view line = next_line(text);
    const std::string_view key = next_token(line);
    if (key == "vertex") {
      for (int axis = 0; axis < 3; ++axis) {
        double value = 0;
        if (!parse_number(next_token(line), value) || !std::isfinite(static_cast<float>(value))) {
          throw Error(subject, "line " + std::to_string(number) + ": a vertex is not three finite numbers");
        }
        corners.push_back(static_cast<float>(value));
      }
      ++in_face;
    } else if (key == "endloop" || key == "endfacet") {
      if (in_face != 0 && in_face != 3) {
        throw Error(subject, "line " + std::to_string(number) + ": a face has " + std::to_string(in_face) + " corners");
      }
      in_face = 0;
    }
  }
  if (in_face != 0) throw Error(subject, "ends within a face");
  return corners;
}

}  // namespace

Mesh parse_stl(std::string_view bytes, const std::string& subject) {
  std::vector<float> corners;
  uint32_t triangles = 0;
  if (bytes.size() >= 84) std::memcpy(&triangles, bytes.data() + 80, 4);
  // Binary files may also begin with "solid": what tells them is that the count fits.
  const bool text = bytes.substr(0, 5) == "solid";
  const bool fits = bytes.size() >= 84 && triangles <= (bytes.size() - 84) / 50;
  if (fits && (!text || 84 + 50ULL * triangles == bytes.size())) {
    corners = binary_corners(bytes, triangles, subject);
  } else if (text) {
    corners = ascii_corners(bytes, subject);
  } else if (bytes.size() >= 84) {
    throw Error(subject, "says it has " + std::to_string(triangles) + " triangles, but ends before them");
  } else {
    throw Error(subject, "is no STL file");
  }
  if (corners.empty()) throw Error(subject, "holds no faces");
  std::vector<int64_t> faces(corners.size() / 3);
  std::iota(faces.begin(), faces.end(), int64_t{0});
  return weld(corners, faces);
}

Mesh parse_off(std::string_view text, const std::string& subject) {
  int64_t number = 0;
  std::string_view line;
  std::string first;
  const auto next = [&] {  // the next line with anything on it
    while (!text.empty()) {
      line = next_line(text);
      ++number;
      line = line.substr(0, line.find('#'));
      std::string_view look = line;
      if (!next_token(look).empty()) return true;
    }
    return false;
  };
  const auto place = [&] { return "line " + std::to_string(number) + ": "; };
  if (!next()) throw Error(subject, "is no OFF file");
  const size_t off = line.find("OFF");
  if (off == std::string_view::npos || off > 4) throw Error(subject, "does not start with 'OFF'");
  first = line.substr(off + 3);
  if (first.find("BINARY") != std::string::npos) throw Error(subject, "is a binary OFF file; only text can be read");
  line = first;
  std::string_view look = line;
  // The counts may stand on the first line, even without a space before them.
  if (next_token(look).empty() && !next()) throw Error(subject, "ends before its counts");
  std::array<uint64_t, 2> counts{};
  for (uint64_t& count : counts) {
    const std::string_view token = next_token(line);
    const auto [end, failed] = std::from_chars(token.data(), token.data() + token.size(), count);
    if (failed != std::errc() || end != token.data() + token.size())
      throw Error(subject, place() + "has no valid counts");
    // A vertex or a face takes two bytes at least.
    if (count > text.size())
      throw Error(subject, "says it has " + std::to_string(count) + " vertices or faces, but ends before them");
  }
  std::vector<float> vertices;
  vertices.reserve(3 * counts[0]);
  for (uint64_t i = 0; i < counts[0]; ++i) {
    if (!next()) throw Error(subject, "ends at vertex " + std::to_string(i) + " of " + std::to_string(counts[0]));
    for (int axis = 0; axis < 3; ++axis) {
      double value = 0;
      if (!parse_number(next_token(line), value) || !std::isfinite(static_cast<float>(value))) {
        throw Error(subject, place() + "a vertex is not three finite numbers");
      }
      vertices.push_back(static_cast<float>(value));
    }
  }
  std::vector<int64_t> faces;
  for (uint64_t i = 0; i < counts[1]; ++i) {
    if (!next()) throw Error(subject, "ends at face " + std::to_string(i) + " of " + std::to_string(counts[1]));
    const auto whole = [&] {
      uint64_t value = 0;
      const std::string_view token = next_token(line);
      const auto [end, failed] = std::from_chars(token.data(), token.data() + token.size(), value);
      if (failed != std::errc() || end != token.data() + token.size())
        throw Error(subject, place() + "a face is no list of vertices");
      return value;
    };
    const uint64_t corners = whole();
    int64_t start = 0, previous = 0;
    for (uint64_t corner = 0; corner < corners; ++corner) {
      const uint64_t index = whole();
      if (index >= counts[0]) {
        throw Error(subject,
                    place() + "a face names vertex " + std::to_string(index) + " of " + std::to_string(counts[0]));
      }
      if (corner == 0) start = static_cast<int64_t>(index);
      if (corner >= 2) faces.insert(faces.end(), {start, previous, static_cast<int64_t>(index)});
      previous = static_cast<int64_t>(index);
    }
  }
  if (faces.empty()) throw Error(subject, "holds no faces");
  Mesh mesh;
  mesh.vertices = torch::tensor(vertices).view({-1, 3});
  mesh.faces = torch::tensor(faces, torch::kInt64).view({-1, 3});
  return mesh;
}

}  // namespace inhabit
