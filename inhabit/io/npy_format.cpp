#include "inhabit/io/npy_format.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>

#include "inhabit/error.h"
#include "inhabit/io/utf8.h"

namespace inhabit {
namespace {

constexpr char kMagic[] = "\x93NUMPY";
constexpr uint64_t kLongestHeader = 1 << 20;
constexpr uint64_t kMostBytes = uint64_t{4} << 30;  ///< of one array

/// Reads the Python dictionary literal that NumPy writes, no more of the language than that.
class HeaderParser {
 public:
  HeaderParser(const std::string& header, const std::string& about) : text_(header), subject_(about) {}

  NpyHeader parse() {
    NpyHeader header;
    bool descr = false, order = false, shape = false;
    expect('{');
    while (!accept('}')) {
      const std::string key = quoted();
      expect(':');
      if (key == "descr") {
        descr = true;
        skip_space();
        if (at_ < text_.size() && text_[at_] == '[')
          skip_list();
        else
          header.descr = quoted();
      } else if (key == "fortran_order") {
        order = true;
        header.fortran_order = boolean();
      } else if (key == "shape") {
        shape = true;
        header.shape = tuple();
      } else {
        fail();
      }
      if (!accept(',')) {
        expect('}');
        break;
      }
    }
    if (!descr || !order || !shape) fail();
    return header;
  }

 private:
  [[noreturn]] void fail() const { throw Error(subject_, "its NumPy header cannot be understood"); }
  void skip_space() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n' || text_[at_] == '\t')) ++at_;
  }
  bool accept(char c) {
    skip_space();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!accept(c)) fail();
  }
  std::string quoted() {
    skip_space();
    if (at_ >= text_.size() || (text_[at_] != '\'' && text_[at_] != '"')) fail();
    const size_t end = text_.find(text_[at_], at_ + 1);
    if (end == std::string::npos) fail();
    const std::string word = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return word;
  }
  bool boolean() {
    skip_space();
    for (const bool value : {true, false}) {
      const std::string word = value ? "True" : "False";
      if (text_.compare(at_, word.size(), word) == 0) {
        at_ += word.size();
        return value;
      }
    }
    fail();
  }
  std::vector<int64_t> tuple() {
    std::vector<int64_t> values;
    expect('(');
    while (!accept(')')) {
      skip_space();
      int64_t value = 0;
      size_t digits = 0;
      for (; at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9'; ++at_, ++digits) {
        if (value > (std::numeric_limits<int64_t>::max() - 9) / 10) fail();
        value = 10 * value + (text_[at_] - '0');
      }
      if (digits == 0) fail();
      accept('L');  // Python 2's long integers
      values.push_back(value);
      if (values.size() > 32) fail();
      if (!accept(',')) {
        expect(')');
        break;
      }
    }
    return values;
  }
  void skip_list() {
    int depth = 0;
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '[') ++depth;
      if (text_[at_] == ']' && --depth == 0) {
        ++at_;
        return;
      }
    }
    fail();
  }

  const std::string& text_;
  const std::string& subject_;
  size_t at_ = 0;
};

/// Reads exactly `size` bytes. Wherever they end early the array is truncated.
void read_exactly(const ByteSource& source, void* to, uint64_t size, const std::string& subject) {
  char* at = static_cast<char*>(to);
  while (size > 0) {
    const uint64_t n = source(at, size);
    if (n == 0) throw Error(subject, "ends early");
    at += n;
    size -= n;
  }
}

void swap_bytes(char* data, int64_t items, int64_t width) {
  for (int64_t i = 0; i < items; ++i) std::reverse(data + i * width, data + (i + 1) * width);
}

std::optional<torch::ScalarType> scalar_type(char kind, int64_t width) {
  switch (kind) {
    case 'f':
      return width == 2   ? std::optional(torch::kHalf)
             : width == 4 ? std::optional(torch::kFloat32)
             : width == 8 ? std::optional(torch::kFloat64)
                          : std::nullopt;
    case 'i':
      return width == 1   ? std::optional(torch::kInt8)
             : width == 2 ? std::optional(torch::kInt16)
             : width == 4 ? std::optional(torch::kInt32)
             : width == 8 ? std::optional(torch::kInt64)
                          : std::nullopt;
    case 'u':  // read as the signed type of the same width, then widened
      return width == 1   ? std::optional(torch::kUInt8)
             : width == 2 ? std::optional(torch::kInt16)
             : width == 4 ? std::optional(torch::kInt32)
             : width == 8 ? std::optional(torch::kInt64)
                          : std::nullopt;
    case 'b':
      return width == 1 ? std::optional(torch::kUInt8) : std::nullopt;
    default:
      return std::nullopt;
  }
}

torch::Tensor widen_unsigned(const torch::Tensor& raw, int64_t width, const std::string& subject) {
  if (width == 2) return raw.to(torch::kInt32).bitwise_and(0xFFFF);
  if (width == 4) return raw.to(torch::kInt64).bitwise_and(int64_t{0xFFFFFFFF});
  if (width == 8 && raw.numel() > 0 && raw.min().item<int64_t>() < 0) throw Error(subject, "has a number beyond 2^63");
  return raw;
}

std::string header_bytes(const std::string& descr, const std::vector<int64_t>& shape) {
  std::string dict = "{'descr': '" + descr + "', 'fortran_order': False, 'shape': (";
  for (const int64_t n : shape) dict += std::to_string(n) + ",";
  if (shape.size() > 1) dict.pop_back();
  dict += "), }";
  dict.append(63 - (dict.size() + 10) % 64, ' ');  // the data begins at a multiple of 64 bytes
  dict += '\n';
  std::string bytes(kMagic, 6);
  bytes += '\x01';
  bytes += '\x00';
  bytes += static_cast<char>(dict.size() & 0xFF);
  bytes += static_cast<char>(dict.size() >> 8);
  return bytes + dict;
}

/// Reads what stands before the data. @param before its bytes. @param size those of the whole array.
NpyHeader read_npy_header(const ByteSource& source, uint64_t size, const std::string& subject, uint64_t& before) {
  char lead[12] = {};
  read_exactly(source, lead, 8, subject);
  if (std::memcmp(lead, kMagic, 6) != 0) throw Error(subject, "is not a NumPy array");
  const int version = static_cast<unsigned char>(lead[6]);
  if (version < 1 || version > 3) throw Error(subject, "has an unknown version of the NumPy format");
  const int count = version == 1 ? 2 : 4;
  read_exactly(source, lead + 8, static_cast<uint64_t>(count), subject);
  uint64_t length = 0;
  for (int i = count - 1; i >= 0; --i) length = (length << 8) | static_cast<unsigned char>(lead[8 + i]);
  before = 8 + static_cast<uint64_t>(count) + length;
  if (length > kLongestHeader || before > size) throw Error(subject, "ends early");
  std::string text(length, '\0');
  read_exactly(source, text.data(), length, subject);
  return HeaderParser(text, subject).parse();
}

/// What an item is.
struct NpyItem {
  std::string skipped;                    ///< why it cannot be read; empty: it can
  char kind = '\0';                       ///< f, i, u, b; U and S are text
  uint64_t width = 0;                     ///< bytes
  bool swap = false;                      ///< its bytes are in the other order
  std::optional<torch::ScalarType> type;  ///< unless text

  bool is_text() const { return kind == 'U' || kind == 'S'; }
};

NpyItem npy_item(const std::string& descr, const std::string& subject) {
  NpyItem item;
  if (descr.empty()) {
    item.skipped = "a structured array";
    return item;
  }
  const bool has_order = descr[0] == '<' || descr[0] == '>' || descr[0] == '|' || descr[0] == '=';
  item.swap = descr[0] == '>';
  item.kind = descr.size() > (has_order ? 1U : 0U) ? descr[has_order ? 1 : 0] : '\0';
  if (item.kind == 'O') {
    item.skipped = "a pickled Python object";
    return item;
  }
  if (item.kind == '\0' || std::strchr("fiubUS", item.kind) == nullptr) {
    item.skipped = "of type " + descr.substr(0, 16);
    return item;
  }
  for (size_t i = has_order ? 2 : 1; i < descr.size(); ++i) {
    if (descr[i] < '0' || descr[i] > '9' || item.width > kMostBytes) throw Error(subject, "has an unknown data type");
    item.width = 10 * item.width + static_cast<uint64_t>(descr[i] - '0');
  }
  if (item.kind == 'U') item.width *= 4;
  item.type = scalar_type(item.kind, static_cast<int64_t>(item.width));
  if (!item.is_text() && !item.type) item.skipped = "of type " + descr.substr(0, 16);
  return item;
}

/// How many items there are. @param size of the file, @param left of it behind the header, bytes.
uint64_t count_items(const std::vector<int64_t>& shape, const NpyItem& item, uint64_t size, uint64_t left,
                     const std::string& subject) {
  uint64_t items = 1;
  for (const int64_t n : shape) {
    if (n == 0) items = 0;
    if (items != 0 && static_cast<uint64_t>(n) > kMostBytes / items) throw Error(subject, "declares an absurd size");
    items *= static_cast<uint64_t>(n);
  }
  // Strings of no width cost memory too.
  if (item.is_text() && items > size) throw Error(subject, "declares an absurd size");
  if (item.width != 0 && items > kMostBytes / item.width) throw Error(subject, "declares an absurd size");
  const uint64_t bytes = items * item.width;
  if (bytes > left)
    throw Error(subject,
                "ends early: " + std::to_string(bytes) + " bytes declared, " + std::to_string(left) + " there");
  return items;
}

StringArray read_strings(const ByteSource& source, const NpyHeader& header, const NpyItem& item, uint64_t items,
                         const std::string& subject) {
  std::string raw(items * item.width, '\0');
  read_exactly(source, raw.data(), raw.size(), subject);
  StringArray strings;
  strings.shape = header.shape;
  if (header.fortran_order && header.shape.size() > 1) strings.shape = {static_cast<int64_t>(items)};
  strings.values.resize(items);
  for (uint64_t i = 0; i < items; ++i) {
    char* at = raw.data() + i * item.width;
    std::string& value = strings.values[i];
    if (item.kind == 'S') {
      value.assign(at, item.width);
    } else {
      if (item.swap) swap_bytes(at, static_cast<int64_t>(item.width / 4), 4);
      for (uint64_t k = 0; k < item.width; k += 4) {
        uint32_t code = 0;
        std::memcpy(&code, at + k, 4);
        append_utf8(value, code);
      }
    }
    value.erase(value.find_last_not_of('\0') + 1);
  }
  return strings;
}

torch::Tensor read_numbers(const ByteSource& source, const NpyHeader& header, const NpyItem& item, uint64_t items,
                           const std::string& subject) {
  const auto width = static_cast<int64_t>(item.width);
  std::vector<int64_t> shape = header.shape;
  if (header.fortran_order) std::reverse(shape.begin(), shape.end());
  torch::Tensor tensor = torch::empty(shape, torch::TensorOptions().dtype(*item.type));
  if (items > 0) read_exactly(source, tensor.data_ptr(), items * item.width, subject);
  if (item.swap) swap_bytes(static_cast<char*>(tensor.data_ptr()), static_cast<int64_t>(items), width);
  if (item.kind == 'u') tensor = widen_unsigned(tensor, width, subject);
  if (item.kind == 'b') tensor = tensor.ne(0);
  if (header.fortran_order && shape.size() > 1) {
    std::vector<int64_t> axes(shape.size());
    for (size_t i = 0; i < axes.size(); ++i) axes[i] = static_cast<int64_t>(axes.size() - 1 - i);
    tensor = tensor.permute(axes).contiguous();
  }
  return tensor;
}

void read_items(const ByteSource& source, uint64_t size, uint64_t left, const NpyHeader& header, const NpyItem& item,
                const std::string& name, const std::string& subject, Npz& into) {
  if (!item.skipped.empty()) {
    into.skipped[name] = item.skipped;
    return;
  }
  const uint64_t items = count_items(header.shape, item, size, left, subject);
  if (item.is_text())
    into.strings[name] = read_strings(source, header, item, items, subject);
  else
    into.tensors[name] = read_numbers(source, header, item, items, subject);
}

}  // namespace

void read_npy(const ByteSource& source, uint64_t size, const std::string& name, const std::string& subject, Npz& into,
              std::string* pickle) {
  uint64_t before = 0;
  const NpyHeader header = read_npy_header(source, size, subject, before);
  const NpyItem item = npy_item(header.descr, subject);
  if (item.kind == 'O' && pickle != nullptr) {
    if (size - before > kMostBytes) throw Error(subject, "declares an absurd size");
    pickle->assign(size - before, '\0');
    read_exactly(source, pickle->data(), pickle->size(), subject);
  }
  read_items(source, size, size - before, header, item, name, subject, into);
}

void read_npy_data(const ByteSource& source, uint64_t size, const NpyHeader& header, const std::string& name,
                   const std::string& subject, Npz& into) {
  read_items(source, size, size, header, npy_item(header.descr, subject), name, subject, into);
}

Npz read_npy_rows(const std::string& path, int64_t first, int64_t count, int64_t* rows) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw Error(path, "there is no such file, or it cannot be read");
  const auto size = static_cast<uint64_t>(file.tellg());
  file.seekg(0);
  const ByteSource source = [&](char* to, uint64_t bytes) {
    file.read(to, static_cast<std::streamsize>(bytes));
    return static_cast<uint64_t>(file.gcount());
  };
  uint64_t before = 0;
  NpyHeader header = read_npy_header(source, size, path, before);
  const NpyItem item = npy_item(header.descr, path);
  if (header.shape.empty()) throw Error(path, "is one value, no array of rows");
  if (header.fortran_order && header.shape.size() > 1) throw Error(path, "is an array in Fortran's order");
  const int64_t all = header.shape[0];
  if (rows != nullptr) *rows = all;
  header.shape[0] = 1;
  const uint64_t wide = item.skipped.empty() ? count_items(header.shape, item, size, size, path) * item.width : 0;
  first = std::clamp<int64_t>(first, 0, all);
  header.shape[0] = std::clamp<int64_t>(count, 0, all - first);
  // Every row must be there, whichever are asked for.
  if (wide != 0 && static_cast<uint64_t>(all) > (size - before) / wide) throw Error(path, "ends early");
  const uint64_t skipped = static_cast<uint64_t>(first) * wide;
  file.seekg(static_cast<std::streamoff>(before + skipped));
  Npz out;
  read_items(source, size, size - before - skipped, header, item, "arr_0", path, out);
  return out;
}

std::string npy_bytes(const torch::Tensor& given) {
  const torch::Tensor tensor = given.detach().to(torch::kCPU).contiguous();
  std::string descr;
  switch (tensor.scalar_type()) {
    case torch::kHalf:
      descr = "<f2";
      break;
    case torch::kFloat32:
      descr = "<f4";
      break;
    case torch::kFloat64:
      descr = "<f8";
      break;
    case torch::kInt8:
      descr = "|i1";
      break;
    case torch::kInt16:
      descr = "<i2";
      break;
    case torch::kInt32:
      descr = "<i4";
      break;
    case torch::kInt64:
      descr = "<i8";
      break;
    case torch::kUInt8:
      descr = "|u1";
      break;
    case torch::kBool:
      descr = "|b1";
      break;
    default:
      throw Error("a tensor of a type that NumPy files cannot hold");
  }
  std::string bytes = header_bytes(descr, tensor.sizes().vec());
  if (tensor.numel() > 0) bytes.append(static_cast<const char*>(tensor.data_ptr()), tensor.nbytes());
  return bytes;
}

std::string npy_bytes(const StringArray& strings) {
  std::vector<std::vector<uint32_t>> codes;
  size_t width = 1;
  for (const std::string& value : strings.values) {
    codes.push_back(code_points(value));
    width = std::max(width, codes.back().size());
  }
  std::string bytes = header_bytes("<U" + std::to_string(width), strings.shape);
  for (std::vector<uint32_t>& item : codes) {
    item.resize(width);
    bytes.append(reinterpret_cast<const char*>(item.data()), width * 4);
  }
  return bytes;
}

}  // namespace inhabit
