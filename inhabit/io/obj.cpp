#include "inhabit/io/obj.h"

#include <map>

#include "inhabit/error.h"
#include "inhabit/io/number_text.h"

namespace inhabit {
namespace {

std::string_view rest_of(std::string_view line) {
  while (!line.empty() && std::isspace(static_cast<unsigned char>(line.front())) != 0) line.remove_prefix(1);
  while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back())) != 0) line.remove_suffix(1);
  return line;
}

using Colors = std::map<std::string, std::array<float, 3>>;  // of materials, linear RGB

void read_colors(std::string_view text, Colors& colors) {
  std::string material;
  bool textured = false;
  while (!text.empty()) {
    std::string_view line = next_line(text);
    const std::string_view key = next_token(line);
    if (key == "newmtl") {
      material = rest_of(line);
      textured = false;
    } else if (key == "map_Kd") {  // the colour beside a texture is white and says nothing
      textured = true;
      colors.erase(material);
    } else if (key == "Kd" && !textured) {
      std::array<float, 3> color{};
      bool good = true;
      for (float& channel : color) {
        double value = 0;
        good = good && parse_number(next_token(line), value) && std::isfinite(value);
        channel = static_cast<float>(std::clamp(value, 0.0, 1.0));
      }
      if (good) colors[material] = color;
    }
  }
}

/// The next line, and behind it those that it goes on in by a backslash at its end, which are put together in `joined`.
/// @param number of the last line that was read, from 1
std::string_view next_joined_line(std::string_view& text, std::string& joined, int64_t& number) {
  std::string_view line = next_line(text);
  ++number;
  if (line.empty() || line.back() != '\\') return line;
  joined.clear();
  while (!line.empty() && line.back() == '\\') {
    joined += line.substr(0, line.size() - 1);
    joined += ' ';
    line = next_line(text);
    ++number;
  }
  joined += line;
  return joined;
}

/// The vertex that a corner of a face ("7", "7/1", "7//2", "-1") names.
bool vertex_of(std::string_view corner, int64_t count, int64_t& index) {
  corner = corner.substr(0, corner.find('/'));
  const auto [end, failed] = std::from_chars(corner.data(), corner.data() + corner.size(), index);
  if (failed != std::errc() || end != corner.data() + corner.size() || index == 0) return false;
  if (index > INT32_MAX || index < -static_cast<int64_t>(INT32_MAX)) return false;
  index = index > 0 ? index - 1 : count + index;
  return index >= 0;
}

/// Faces of one object and material, by numbers of the file's vertices.
struct Group {
  std::string name, material;
  std::vector<int64_t> faces;
};

/// A mesh of each group that has faces, with the vertices that it uses.
std::vector<Mesh> meshes_of(const std::vector<Group>& groups, const std::vector<float>& vertices,
                            const Colors& colors) {
  std::vector<Mesh> meshes;
  std::vector<int64_t> local(vertices.size() / 3, -1);  // a vertex's number in the mesh at hand
  for (const Group& source : groups) {
    if (source.faces.empty()) continue;
    std::vector<float> used;
    std::vector<int64_t> faces;
    faces.reserve(source.faces.size());
    for (const int64_t index : source.faces) {
      int64_t& to = local[static_cast<size_t>(index)];
      if (to < 0) {
        to = static_cast<int64_t>(used.size() / 3);
        used.insert(used.end(), vertices.begin() + 3 * index, vertices.begin() + 3 * index + 3);
      }
      faces.push_back(to);
    }
    for (const int64_t index : source.faces) local[static_cast<size_t>(index)] = -1;
    Mesh& mesh = meshes.emplace_back();
    mesh.name = source.name.empty() ? source.material : source.name;
    if (const auto color = colors.find(source.material); color != colors.end()) mesh.color = color->second;
    mesh.vertices = torch::tensor(used).view({-1, 3});
    mesh.faces = torch::tensor(faces, torch::kInt64).view({-1, 3});
  }
  return meshes;
}

}  // namespace

std::vector<Mesh> parse_obj(std::string_view text, const std::string& subject,
                            const std::function<std::string(const std::string&)>& open) {
  std::vector<float> vertices;
  Colors colors;
  std::vector<Group> groups;
  std::map<std::pair<std::string, std::string>, size_t> known;
  std::string object, material;
  bool objects_named = false;
  Group* group = nullptr;
  size_t current = 0;
  int64_t most = -1;  // the highest vertex named so far, and the line that did: faces may come before vertices
  int64_t most_line = 0, number = 0;
  std::string joined;
  while (!text.empty()) {
    std::string_view line = next_joined_line(text, joined, number);
    line = line.substr(0, line.find('#'));
    const std::string_view key = next_token(line);
    const auto place = [&] { return "line " + std::to_string(number) + ": "; };
    if (key == "v") {
      for (int axis = 0; axis < 3; ++axis) {
        double value = 0;
        if (!parse_number(next_token(line), value)) throw Error(subject, place() + "a vertex is not three numbers");
        if (!std::isfinite(static_cast<float>(value))) throw Error(subject, place() + "a vertex is not finite");
        vertices.push_back(static_cast<float>(value));
      }
    } else if (key == "f") {
      if (group == nullptr) {
        const auto [found, added] = known.try_emplace({object, material}, groups.size());
        if (added) groups.push_back({object, material, {}});
        current = found->second;
        group = &groups[current];
      }
      int64_t first = 0, previous = 0, corners = 0;
      for (std::string_view corner = next_token(line); !corner.empty(); corner = next_token(line), ++corners) {
        int64_t index = 0;
        if (!vertex_of(corner, static_cast<int64_t>(vertices.size() / 3), index)) {
          throw Error(subject, place() + "a face has the invalid corner '" + std::string(corner.substr(0, 20)) + "'");
        }
        if (index > most) {
          most = index;
          most_line = number;
        }
        if (corners == 0) first = index;
        if (corners >= 2) group->faces.insert(group->faces.end(), {first, previous, index});
        previous = index;
      }
    } else if (key == "o" || (key == "g" && !objects_named)) {
      objects_named = key == "o";
      object = rest_of(line);
      group = nullptr;
    } else if (key == "usemtl") {
      material = rest_of(line);
      group = nullptr;
    } else if (key == "mtllib") {
      read_colors(open(std::string(rest_of(line))), colors);
    }
  }
  const auto count = static_cast<int64_t>(vertices.size() / 3);
  if (most >= count) {
    throw Error(subject, "line " + std::to_string(most_line) + ": a face names vertex " + std::to_string(most + 1) +
                             " of " + std::to_string(count));
  }

  std::vector<Mesh> meshes = meshes_of(groups, vertices, colors);
  if (meshes.empty()) throw Error(subject, "holds no faces");
  return meshes;
}

}  // namespace inhabit
