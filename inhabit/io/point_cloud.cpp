#include "inhabit/io/point_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/number_text.h"
#include "inhabit/io/ply.h"
#include "inhabit/io/text_lines.h"

namespace inhabit {
namespace {

torch::Tensor to_points(const std::vector<float>& values, const std::string& subject) {
  if (values.empty()) throw Error(subject, "holds no points");
  return torch::tensor(values).view({-1, 3});
}

std::string line_place(int64_t line) { return "line " + std::to_string(line); }

/// Numbers of one line of text, whatever separates them; false where there is something else on the line.
bool numbers_of(std::string_view line, std::vector<double>& numbers) {
  numbers.clear();
  const size_t comment = std::min(line.find('#'), line.find("//"));
  std::string text(line.substr(0, comment));
  std::replace(text.begin(), text.end(), ';', ' ');
  // "1,5 2,0 3,1": every token has at most one comma, and digits on both sides of it. "1, 2, 3" and "1,2,3" do not.
  bool decimal_comma = text.find(',') != std::string::npos && text.find('.') == std::string::npos;
  size_t tokens = 0;
  for (std::string_view rest = text; decimal_comma;) {
    const std::string_view token = next_token(rest);
    if (token.empty()) break;
    ++tokens;
    const size_t comma = token.find(',');
    if (comma == std::string_view::npos) continue;
    decimal_comma = comma > 0 && comma + 1 < token.size() && token.find(',', comma + 1) == std::string_view::npos;
  }
  std::replace(text.begin(), text.end(), ',', decimal_comma && tokens >= 3 ? '.' : ' ');
  for (std::string_view rest = text;;) {
    const std::string_view token = next_token(rest);
    double value = 0;
    if (token.empty()) return true;
    if (!parse_number(token, value)) return false;
    numbers.push_back(value);
  }
}

torch::Tensor parse_xyz(std::string_view text, const std::string& subject) {
  if (text.substr(0, 4096).find('\0') != std::string_view::npos) throw Error(subject, "is binary, not text");
  std::vector<float> values;
  std::vector<double> numbers;
  bool heading_allowed = true;
  for (int64_t line = 1; !text.empty(); ++line) {
    const bool readable = numbers_of(next_line(text), numbers);
    if (readable && numbers.empty()) continue;
    const bool heading =
        heading_allowed && (!readable || (numbers.size() == 1 && numbers[0] == std::floor(numbers[0])));
    heading_allowed = false;
    if (heading) continue;
    if (!readable || numbers.size() < 3) throw Error(subject, line_place(line) + " is not three numbers");
    for (size_t axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(static_cast<float>(numbers[axis]))) throw Error(subject, line_place(line) + " is not finite");
      values.push_back(static_cast<float>(numbers[axis]));
    }
  }
  return to_points(values, subject);
}

struct PcdField {
  std::string name;
  uint64_t size = 4;
  char type = 'F';
  uint64_t count = 1;
  uint64_t offset = 0;  ///< bytes into a point (binary), or tokens into a line (ascii)
};

/// LZF (Marc Lehmann's format, as PCD uses it) into exactly out.size() bytes.
void unpack_lzf(std::string_view in, std::string& out, const std::string& subject) {
  size_t i = 0, o = 0;
  const auto byte = [&]() -> size_t {
    if (i >= in.size()) throw Error(subject, "its compressed points end early");
    return static_cast<unsigned char>(in[i++]);
  };
  while (o < out.size()) {
    const size_t control = byte();
    if (control < 32) {  // a run of literal bytes
      const size_t length = control + 1;
      if (length > in.size() - i || length > out.size() - o) throw Error(subject, "its compressed points are damaged");
      std::memcpy(out.data() + o, in.data() + i, length);
      i += length;
      o += length;
    } else {  // a copy of what came before
      size_t length = control >> 5;
      if (length == 7) length += byte();
      length += 2;
      const size_t back = ((control & 31) << 8) + byte() + 1;
      if (back > o || length > out.size() - o) throw Error(subject, "its compressed points are damaged");
      for (size_t k = 0; k < length; ++k, ++o) out[o] = out[o - back];
    }
  }
}

double pcd_value(const char* raw, const PcdField& field) {
  const auto as = [&](auto value) {
    std::memcpy(&value, raw, sizeof(value));
    return static_cast<double>(value);
  };
  switch (field.type) {
    case 'F':
      return field.size == 8 ? as(double()) : as(float());
    case 'I':
      return field.size == 1   ? as(int8_t())
             : field.size == 2 ? as(int16_t())
             : field.size == 4 ? as(int32_t())
                               : as(int64_t());
    default:
      return field.size == 1   ? as(uint8_t())
             : field.size == 2 ? as(uint16_t())
             : field.size == 4 ? as(uint32_t())
                               : as(uint64_t());
  }
}

struct PcdHeader {
  std::vector<PcdField> fields;
  uint64_t points = 0;
  std::string_view form;                  ///< of the data: ascii, binary, binary_compressed
  uint64_t stride = 0;                    ///< of a point: bytes (binary), or tokens (ascii)
  std::array<const PcdField*, 3> axes{};  ///< x, y, z among `fields`
};

/// Takes the header off the front of `text`: its rows up to DATA.
PcdHeader read_pcd_rows(std::string_view& text, const std::string& subject) {
  PcdHeader header;
  uint64_t width = 0, height = 1;
  // FIELDS, SIZE, TYPE and COUNT are rows of one table, one column a field.
  const auto each_field = [&](std::string_view line, const auto& set) {
    for (PcdField& field : header.fields) {
      const std::string_view token = next_token(line);
      if (token.empty()) throw Error(subject, "PCD header has fewer entries than fields");
      set(field, token);
    }
  };
  const auto whole = [&](std::string_view token) {
    double value = 0;
    if (!parse_number(token, value) || value < 0 || value > 1e12 || value != std::floor(value)) {
      throw Error(subject, "PCD header has no valid number in " + in_quotes(token.substr(0, 20)));
    }
    return static_cast<uint64_t>(value);
  };
  while (header.form.empty()) {
    if (text.empty()) throw Error(subject, "PCD header does not end");
    std::string_view line = next_line(text);
    const std::string_view key = next_token(line);
    if (key == "FIELDS" || key == "COLUMNS") {
      for (std::string_view name = next_token(line); !name.empty(); name = next_token(line)) {
        header.fields.emplace_back().name = name;
      }
    } else if (key == "SIZE") {
      each_field(line, [&](PcdField& field, std::string_view token) { field.size = whole(token); });
    } else if (key == "TYPE") {
      each_field(line, [](PcdField& field, std::string_view token) { field.type = token.front(); });
    } else if (key == "COUNT") {
      each_field(line, [&](PcdField& field, std::string_view token) { field.count = whole(token); });
    } else if (key == "WIDTH") {
      width = whole(next_token(line));
    } else if (key == "HEIGHT") {
      height = whole(next_token(line));
    } else if (key == "POINTS") {
      header.points = whole(next_token(line));
    } else if (key == "DATA") {
      header.form = next_token(line);
      if (header.form.empty()) throw Error(subject, "PCD header names no data form");
    } else if (!key.empty() && key.front() != '#' && key != "VERSION" && key != "VIEWPOINT") {
      const bool text_line = std::all_of(key.begin(), key.end(), [](char c) { return c >= 32 && c < 127; });
      throw Error(subject, "is no PCD file" + (text_line ? ": its header has " + in_quotes(key) : std::string()));
    }
  }
  if (header.points == 0 && width > 0 && height <= (uint64_t{1} << 40) / width) header.points = width * height;
  if (header.points == 0) throw Error(subject, "holds no points");
  return header;
}

/// Checks the fields and finds where in a point each of them is.
void lay_out_fields(PcdHeader& header, const std::string& subject) {
  for (PcdField& field : header.fields) {
    if ((field.size != 1 && field.size != 2 && field.size != 4 && field.size != 8) || field.count > 4096 ||
        std::string_view("FIU").find(field.type) == std::string_view::npos || (field.type == 'F' && field.size < 4)) {
      throw Error(subject, "PCD field " + in_quotes(field.name.substr(0, 30)) + " has no valid size, type or count");
    }
    field.offset = header.stride;
    header.stride += header.form == "ascii" ? field.count : field.size * field.count;
    for (size_t axis = 0; axis < 3; ++axis) {
      if (field.name == std::string(1, "xyz"[axis]) && field.count == 1) header.axes[axis] = &field;
    }
  }
  if (std::count(header.axes.begin(), header.axes.end(), nullptr) > 0)
    throw Error(subject, "PCD header has no fields x, y and z");
}

/// Points that were not measured are NaN in PCD and are left out.
void add_point(const std::array<double, 3>& point, std::vector<float>& values, const std::string& subject) {
  std::array<float, 3> out{};
  for (size_t axis = 0; axis < 3; ++axis) out[axis] = static_cast<float>(point[axis]);
  if (std::isfinite(out[0]) && std::isfinite(out[1]) && std::isfinite(out[2])) {
    values.insert(values.end(), out.begin(), out.end());
  } else if (std::isinf(out[0]) || std::isinf(out[1]) || std::isinf(out[2])) {
    throw Error(subject, "a point is infinite");
  }
}

torch::Tensor ascii_points(const PcdHeader& header, std::string_view text, const std::string& subject) {
  const std::string points = std::to_string(header.points);
  if (header.points > text.size()) throw Error(subject, "says it has " + points + " points, but ends before them");
  std::vector<float> values;
  for (uint64_t i = 0; i < header.points; ++i) {
    std::array<double, 3> point{};
    for (uint64_t column = 0; column < header.stride; ++column) {
      const std::string_view token = next_token(text);
      if (token.empty()) throw Error(subject, "ends at point " + std::to_string(i) + " of " + points);
      for (size_t axis = 0; axis < 3; ++axis) {
        if (header.axes[axis]->offset == column && !parse_number(token, point[axis])) {
          throw Error(subject, "point " + std::to_string(i) + " is not three numbers");
        }
      }
    }
    add_point(point, values, subject);
  }
  return to_points(values, subject);
}

/// The points of binary_compressed data, unpacked.
std::string unpacked_points(const PcdHeader& header, std::string_view text, const std::string& subject) {
  if (text.size() < 8) throw Error(subject, "ends before its points");
  std::array<uint32_t, 2> sizes{};
  std::memcpy(sizes.data(), text.data(), 8);
  text.remove_prefix(8);
  // LZF makes at most 264 bytes of 3.
  if (sizes[0] > text.size() || sizes[1] / 88 > sizes[0] || header.points > sizes[1] / header.stride) {
    throw Error(subject, "its compressed size is impossible");
  }
  std::string unpacked(sizes[1], '\0');
  unpack_lzf(text.substr(0, sizes[0]), unpacked, subject);
  return unpacked;
}

torch::Tensor binary_points(const PcdHeader& header, std::string_view bytes, const std::string& subject) {
  const bool compressed = header.form == "binary_compressed";
  if (header.points > bytes.size() / header.stride) {
    throw Error(subject, "says it has " + std::to_string(header.points) + " points, but ends before them");
  }
  std::vector<float> values;
  for (uint64_t i = 0; i < header.points; ++i) {
    std::array<double, 3> point{};
    for (size_t axis = 0; axis < 3; ++axis) {
      const PcdField& field = *header.axes[axis];
      // Compressed files keep one field of all points after the other.
      const uint64_t at = compressed ? header.points * field.offset + i * field.size : i * header.stride + field.offset;
      point[axis] = pcd_value(bytes.data() + at, field);
    }
    add_point(point, values, subject);
  }
  return to_points(values, subject);
}

torch::Tensor parse_pcd(std::string_view text, const std::string& subject) {
  PcdHeader header = read_pcd_rows(text, subject);
  lay_out_fields(header, subject);
  if (header.form == "ascii") return ascii_points(header, text, subject);
  if (header.form == "binary") return binary_points(header, text, subject);
  if (header.form == "binary_compressed") return binary_points(header, unpacked_points(header, text, subject), subject);
  throw Error(subject, "PCD data form " + in_quotes(header.form.substr(0, 20)) + " is unknown");
}

const std::vector<std::string> kPointArrays{"points", "xyz", "positions", "arr_0"};

torch::Tensor parse_npz_points(std::string_view bytes, const std::string& subject) {
  const Npz archive = parse_npz(bytes, subject, kPointArrays);
  for (const std::string& name : kPointArrays) {
    if (!archive.has(name)) continue;
    const torch::Tensor& array = archive.at(name, subject);
    if (array.dim() != 2 || array.size(1) < 3) throw Error(subject, "its array '" + name + "' is not (N, 3)");
    if (array.size(0) == 0) throw Error(subject, "holds no points");
    const torch::Tensor points = array.slice(1, 0, 3).to(torch::kFloat32).contiguous();
    if (!torch::isfinite(points).all().item<bool>()) throw Error(subject, "a point of '" + name + "' is not finite");
    return points;
  }
  throw Error(subject,
              "has no array 'points', 'xyz' or 'positions', nor any that motion is read from, such as 'joints' or "
              "'keypoints' (T, J, 3)");
}

}  // namespace

bool holds_points(const Npz& npz) {
  return std::any_of(kPointArrays.begin(), kPointArrays.end(), [&](const std::string& name) { return npz.has(name); });
}

torch::Tensor parse_point_cloud(std::string_view bytes, const std::string& extension, const std::string& subject) {
  if (bytes.empty()) throw Error(subject, "is empty");
  if (extension == "ply") return parse_ply(bytes, subject).vertices;
  if (extension == "pcd") return parse_pcd(bytes, subject);
  if (extension == "npz" || extension == "npy") return parse_npz_points(bytes, subject);
  if (extension == "xyz" || extension == "txt" || extension == "pts" || extension == "csv")
    return parse_xyz(bytes, subject);
  throw Error(subject, "'" + extension + "' is no point cloud format; known are ply, pcd, xyz, npz");
}

torch::Tensor read_point_cloud(const std::string& path) {
  return parse_point_cloud(read_whole_file(path), extension_of(path), path);
}

}  // namespace inhabit
