#include "inhabit/io/ply.h"

#include <bit>
#include <cstring>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/number_text.h"

namespace inhabit {
namespace {

// PLY itself has no axes or units.
constexpr std::string_view kOurAxes = "inhabit: metres, +Y up";

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string name;
  Type type = Type::float32;
  bool list = false;
  Type count_type = Type::uint8;
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
};

struct PlyHeader {
  enum class Format { ascii, little, big } format = Format::ascii;
  std::vector<Element> elements;
  bool ours = false;  // of write_ply
};

size_t size_of(Type type) {
  switch (type) {
    case Type::int8:
    case Type::uint8:
      return 1;
    case Type::int16:
    case Type::uint16:
      return 2;
    case Type::float64:
      return 8;
    default:
      return 4;
  }
}

Type type_named(std::string_view name, const std::string& subject) {
  if (name == "char" || name == "int8") return Type::int8;
  if (name == "uchar" || name == "uint8") return Type::uint8;
  if (name == "short" || name == "int16") return Type::int16;
  if (name == "ushort" || name == "uint16") return Type::uint16;
  if (name == "int" || name == "int32") return Type::int32;
  if (name == "uint" || name == "uint32") return Type::uint32;
  if (name == "float" || name == "float32") return Type::float32;
  if (name == "double" || name == "float64") return Type::float64;
  throw Error(subject, "PLY header names an unknown type '" + std::string(name.substr(0, 20)) + "'");
}

/// Cuts the header off `text`.
PlyHeader read_header(std::string_view& text, const std::string& subject) {
  PlyHeader header;
  bool format_seen = false;
  if (next_line(text) != "ply") throw Error(subject, "does not start with 'ply'");
  while (!text.empty()) {
    std::string_view line = next_line(text);
    const std::string_view key = next_token(line);
    if (key == "end_header") {
      if (!format_seen) throw Error(subject, "PLY header has no format");
      return header;
    }
    if (key == "format") {
      const std::string_view format = next_token(line);
      if (format == "ascii") {
        header.format = PlyHeader::Format::ascii;
      } else if (format == "binary_little_endian") {
        header.format = PlyHeader::Format::little;
      } else if (format == "binary_big_endian") {
        header.format = PlyHeader::Format::big;
      } else {
        throw Error(subject, "PLY format '" + std::string(format.substr(0, 30)) + "' is unknown");
      }
      format_seen = true;
    } else if (key == "comment") {
      if (line.find(kOurAxes) != std::string_view::npos) header.ours = true;
    } else if (key == "element") {
      Element element;
      element.name = next_token(line);
      const std::string_view count = next_token(line);
      const auto [end, failed] = std::from_chars(count.data(), count.data() + count.size(), element.count);
      if (failed != std::errc() || end != count.data() + count.size()) {
        throw Error(subject, "PLY element '" + element.name.substr(0, 30) + "' has no valid count");
      }
      header.elements.push_back(std::move(element));
    } else if (key == "property") {
      if (header.elements.empty()) throw Error(subject, "PLY property before any element");
      Property property;
      std::string_view type = next_token(line);
      if (type == "list") {
        property.list = true;
        property.count_type = type_named(next_token(line), subject);
        type = next_token(line);
      }
      property.type = type_named(type, subject);
      property.name = next_token(line);
      header.elements.back().properties.push_back(std::move(property));
    }
  }
  throw Error(subject, "PLY header does not end");
}

/// Values of the body one after the other, ascii or binary.
class Body {
 public:
  Body(std::string_view bytes, PlyHeader::Format format, const std::string& subject)
      : bytes_(bytes), ascii_(format == PlyHeader::Format::ascii), subject_(subject) {
    const bool little = std::endian::native == std::endian::little;
    swap_ = !ascii_ && (format == PlyHeader::Format::little) != little;
  }

  double next(Type type) {
    if (ascii_) {
      const std::string_view token = next_token(bytes_);
      double value = 0;
      if (token.empty()) throw Error(subject_, "ends before its last element");
      if (!parse_number(token, value)) throw Error(subject_, "'" + std::string(token.substr(0, 20)) + "' is no number");
      return value;
    }
    const size_t size = size_of(type);
    if (bytes_.size() < size) throw Error(subject_, "ends before its last element");
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), bytes_.data(), size);
    bytes_.remove_prefix(size);
    if (swap_) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    switch (type) {
      case Type::int8:
        return as<int8_t>(raw);
      case Type::uint8:
        return as<uint8_t>(raw);
      case Type::int16:
        return as<int16_t>(raw);
      case Type::uint16:
        return as<uint16_t>(raw);
      case Type::int32:
        return as<int32_t>(raw);
      case Type::uint32:
        return as<uint32_t>(raw);
      case Type::float32:
        return static_cast<double>(as<float>(raw));
      case Type::float64:
        return as<double>(raw);
    }
    return 0;
  }

  uint64_t next_count(Type type) {
    const double value = next(type);
    // Every item takes a byte at least, so that more items than bytes are a lie.
    if (!(value >= 0) || value > static_cast<double>(bytes_.size())) throw Error(subject_, "a list runs past the end");
    return static_cast<uint64_t>(value);
  }

  void skip(const Property& property) {
    const uint64_t count = property.list ? next_count(property.count_type) : 1;
    for (uint64_t i = 0; i < count; ++i) next(property.type);
  }

  /// Refuses an element that needs more bytes than are left, before anything is allocated for it.
  void check_fits(const Element& element) const {
    uint64_t least = 0;
    for (const Property& property : element.properties) {
      least += ascii_ ? 1 : size_of(property.list ? property.count_type : property.type);
    }
    if (least > 0 && element.count > (bytes_.size() + 1) / least) {
      throw Error(subject_, "says it has " + std::to_string(element.count) + " of '" + element.name.substr(0, 30) +
                                "', but ends before them");
    }
  }

 private:
  template <typename T>
  static T as(const std::array<char, 8>& raw) {
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

  std::string_view bytes_;
  bool ascii_;
  bool swap_ = false;
  const std::string& subject_;
};

void read_vertices(Body& body, const Element& element, Mesh& mesh, const std::string& subject) {
  std::array<int, 3> seen{};
  std::vector<int> role;  // 0-2 position, 3-5 colour, -1 neither
  const std::array<const char*, 6> names{"x", "y", "z", "red", "green", "blue"};
  for (const Property& property : element.properties) {
    const auto* found = std::find(names.begin(), names.end(), property.name);
    const int known = found == names.end() || property.list ? -1 : static_cast<int>(found - names.begin());
    if (known >= 0 && known < 3) seen[static_cast<size_t>(known)] += 1;
    role.push_back(known >= 3 && property.type != Type::uint8 ? -1 : known);
  }
  if (seen != std::array<int, 3>{1, 1, 1}) throw Error(subject, "its vertices have no x, y and z");
  const bool colored = std::count_if(role.begin(), role.end(), [](int r) { return r >= 3; }) == 3;

  mesh.vertices = torch::empty({static_cast<int64_t>(element.count), 3});
  float* out = mesh.vertices.data_ptr<float>();
  std::array<double, 3> color{};
  for (uint64_t i = 0; i < element.count; ++i, out += 3) {
    for (size_t p = 0; p < role.size(); ++p) {
      if (role[p] < 0) {
        body.skip(element.properties[p]);
        continue;
      }
      const double value = body.next(element.properties[p].type);
      if (role[p] >= 3) {
        color[static_cast<size_t>(role[p] - 3)] += std::pow(value / 255.0, 2.2);
      } else if (std::isfinite(static_cast<float>(value))) {
        out[role[p]] = static_cast<float>(value);
      } else {
        throw Error(subject, "vertex " + std::to_string(i) + " is not finite");
      }
    }
  }
  if (colored && element.count > 0) {
    for (size_t c = 0; c < 3; ++c) mesh.color[c] = static_cast<float>(color[c] / static_cast<double>(element.count));
  }
}

void read_faces(Body& body, const Element& element, std::vector<int64_t>& faces, const std::string& subject) {
  bool found = false;
  for (const Property& property : element.properties) {
    found = found || (property.list && (property.name == "vertex_indices" || property.name == "vertex_index"));
  }
  if (!found && element.count > 0) throw Error(subject, "its faces have no vertex_indices");
  faces.reserve(3 * element.count);
  for (uint64_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      if (!property.list || (property.name != "vertex_indices" && property.name != "vertex_index")) {
        body.skip(property);
        continue;
      }
      const uint64_t corners = body.next_count(property.count_type);
      int64_t first = 0, previous = 0;
      for (uint64_t corner = 0; corner < corners; ++corner) {
        const double value = body.next(property.type);
        if (!(value >= 0 && value < 9e15)) throw Error(subject, "face " + std::to_string(i) + " has an invalid index");
        const auto index = static_cast<int64_t>(value);
        if (corner == 0) first = index;
        if (corner >= 2) faces.insert(faces.end(), {first, previous, index});
        previous = index;
      }
    }
  }
}

}  // namespace

Mesh parse_ply(std::string_view bytes, const std::string& subject, MeshAxes* axes) {
  const PlyHeader header = read_header(bytes, subject);
  if (header.ours && axes != nullptr) *axes = {'y', 1};
  Body body(bytes, header.format, subject);
  Mesh mesh;
  std::vector<int64_t> faces;
  for (const Element& element : header.elements) {
    if (element.properties.empty()) continue;
    body.check_fits(element);
    if (element.name == "vertex") {
      if (mesh.vertices.defined()) throw Error(subject, "has its vertices twice");
      read_vertices(body, element, mesh, subject);
    } else if (element.name == "face") {
      read_faces(body, element, faces, subject);
    } else {
      for (uint64_t i = 0; i < element.count; ++i) {
        for (const Property& property : element.properties) body.skip(property);
      }
    }
  }
  if (!mesh.vertices.defined() || mesh.vertices.size(0) == 0) throw Error(subject, "has no vertices");
  const int64_t vertex_count = mesh.vertices.size(0);
  for (const int64_t index : faces) {
    if (index >= vertex_count) {
      throw Error(subject, "a face names vertex " + std::to_string(index) + " of " + std::to_string(vertex_count));
    }
  }
  mesh.faces = torch::tensor(faces, torch::kInt64).view({-1, 3});
  return mesh;
}

void write_ply(const std::string& path, const Scene& scene) {
  if (scene.empty()) throw Error(path, "there is nothing to write: no mesh, no point");
  Mesh mesh = merged_mesh(scene);
  if (scene.meshes.empty()) mesh.vertices = scene.points;
  const torch::Tensor vertices = mesh.vertices.to(torch::kFloat32).contiguous();
  std::string bytes = "ply\nformat binary_little_endian 1.0\ncomment " + std::string(kOurAxes) + "\nelement vertex " +
                      std::to_string(vertices.size(0)) + "\nproperty float x\nproperty float y\nproperty float z\n";
  if (mesh.faces.size(0) > 0)
    bytes += "element face " + std::to_string(mesh.faces.size(0)) + "\nproperty list uchar int vertex_indices\n";
  bytes += "end_header\n";
  bytes.append(static_cast<const char*>(vertices.data_ptr()), vertices.nbytes());
  const torch::Tensor faces = mesh.faces.to(torch::kInt32).contiguous();
  const auto* corners = static_cast<const char*>(faces.data_ptr());
  for (int64_t f = 0; f < faces.size(0); ++f) {
    bytes += '\x03';
    bytes.append(corners + 12 * f, 12);
  }
  write_atomically(path, bytes);
}

}  // namespace inhabit
