#include "inhabit/io/cdf.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <set>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/npy_format.h"

namespace inhabit {
namespace {

// Names and numbers are those of NASA's "CDF Internal Format Description". A file is made of records that name each
// other by their places in it. What describes is big-endian, whatever encoding the values have.

constexpr int64_t kCdfDescriptor = 1, kGlobalDescriptor = 2, kSharedVariable = 3, kVariableIndex = 6, kPlainValues = 7,
                  kOwnVariable = 8, kPackedFile = 10, kPacking = 11, kPackedValues = 13;
constexpr int64_t kGzip = 5;
constexpr uint64_t kMostCdfBytes = uint64_t{4} << 30;  ///< of one variable
constexpr uint64_t kBestRatio = 1032;                  ///< bytes that deflate packs into one at best
constexpr int64_t kMostCdfDimensions = 10;             ///< the library's CDF_MAX_DIMS
constexpr int kDeepestIndex = 16;

/// What a record says, from front to back.
struct CdfRecord {
  std::string_view left;
  bool wide;  ///< version 3: places and sizes have 64 bits, and not 32
  const std::string& subject;

  std::string_view take(uint64_t size) {
    if (size > left.size()) throw Error(subject, "ends early");
    const std::string_view out = left.substr(0, size);
    left.remove_prefix(size);
    return out;
  }
  int64_t number(uint64_t width) {
    uint64_t out = 0;
    for (const char c : take(width)) out = (out << 8) | static_cast<unsigned char>(c);
    return width == 4 ? static_cast<int32_t>(static_cast<uint32_t>(out)) : static_cast<int64_t>(out);
  }
  int64_t number() { return number(4); }
  int64_t place() { return number(wide ? 8 : 4); }
};

struct CdfFile {
  std::string_view bytes;
  const std::string& subject;
  bool wide = true;
  bool big_endian = false, column_major = false;
  std::vector<int64_t> shared_shape = {};  ///< of variables of the older kind, which all have it
  uint64_t values_left = 0;                ///< bytes of values that the file can still have: no two variables share any
  uint64_t unpacked_left = 0;              ///< bytes that may still be unpacked, though what was packed be packed again
  std::set<int64_t> visited = {};          ///< places of records in lists, of which none comes twice
};

/// The record at a place, behind its size and its kind. @param kind set to the kind
CdfRecord any_record(const CdfFile& file, int64_t at, int64_t& kind) {
  if (at < 8 || static_cast<uint64_t>(at) >= file.bytes.size())
    throw Error(file.subject, "is cut short or damaged: it points beyond its end");
  CdfRecord record = {file.bytes.substr(static_cast<size_t>(at)), file.wide, file.subject};
  const uint64_t before = record.left.size();
  const int64_t size = record.place();
  kind = record.number();
  const uint64_t head = before - record.left.size();
  if (size < static_cast<int64_t>(head) || static_cast<uint64_t>(size) > before)
    throw Error(file.subject, "is cut short or damaged: a record of it goes beyond its end");
  record.left = record.left.substr(0, static_cast<size_t>(size) - head);
  return record;
}

CdfRecord record_of(const CdfFile& file, int64_t at, int64_t wanted) {
  int64_t kind = 0;
  const CdfRecord record = any_record(file, at, kind);
  if (kind != wanted)
    throw Error(file.subject, "is damaged: it has a record of kind " + std::to_string(kind) + " where one of kind " +
                                  std::to_string(wanted) + " should be");
  return record;
}

void visit(CdfFile& file, int64_t at) {
  if (!file.visited.insert(at).second) throw Error(file.subject, "is damaged: its records lead in a circle");
}

/// The first `size` bytes of what gzip packed.
std::string gunzipped(std::string_view packed, uint64_t size, uint64_t& left, const std::string& subject) {
  if (size / kBestRatio > packed.size() + 64 || size > left) throw Error(subject, "declares an absurd size");
  left -= size;
  std::string out(size, '\0');
  z_stream stream = {};
  constexpr int kEitherHeader = 15 + 32;
  if (inflateInit2(&stream, kEitherHeader) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, decltype(&inflateEnd)> ends(&stream, &inflateEnd);
  constexpr uint64_t kAtOnce = 1 << 30;  // zlib counts in 32 bits
  uint64_t read = 0, made = 0;
  for (int state = Z_OK; state != Z_STREAM_END;) {
    char more = 0;  // at the end the checksum is compared
    const bool full = made == size;
    const auto in = static_cast<uInt>(std::min(packed.size() - read, kAtOnce));
    const auto room = static_cast<uInt>(full ? 1 : std::min(size - made, kAtOnce));
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data() + read));
    stream.avail_in = in;
    stream.next_out = reinterpret_cast<Bytef*>(full ? &more : out.data() + made);
    stream.avail_out = room;
    state = inflate(&stream, Z_NO_FLUSH);
    read += in - stream.avail_in;
    if (full && stream.avail_out == 0) break;  // blocks have room for records that were not written
    made += full ? 0 : room - stream.avail_out;
    if (state == Z_BUF_ERROR || (state == Z_STREAM_END && made < size)) throw Error(subject, "ends early");
    if (state != Z_OK && state != Z_STREAM_END) throw Error(subject, "is damaged: it cannot be unpacked");
  }
  return out;
}

/// How a file, or a variable, is packed. @param at where that is said
int64_t packing_at(const CdfFile& file, int64_t at) { return record_of(file, at, kPacking).number(); }

std::string packing_name(int64_t packing) {
  return packing == 1   ? "run lengths"
         : packing == 2 ? "Huffman codes"
         : packing == 3 ? "adaptive Huffman codes"
                        : "method " + std::to_string(packing);
}

/// Descriptions as NumPy's of what can be read; empty for all else.
std::string item_of(int64_t type) {
  switch (type) {
    case 1:   // INT1
    case 41:  // BYTE
      return "i1";
    case 2:
      return "i2";
    case 4:
      return "i4";
    case 8:
    case 33:  // TIME_TT2000
      return "i8";
    case 11:
      return "u1";
    case 12:
      return "u2";
    case 14:
      return "u4";
    case 21:  // REAL4
    case 44:  // FLOAT
      return "f4";
    case 22:  // REAL8
    case 45:  // DOUBLE
    case 31:  // EPOCH
      return "f8";
    default:
      return "";
  }
}

struct CdfVariable {
  std::string name;
  int64_t type = 0, last_record = -1, index = 0, packing = 0;
  int64_t elements = 1;  ///< letters of a text
  bool varies = true;    ///< from record to record
  bool sparse = false;
  std::vector<int64_t> shape;  ///< of a record
};

std::string variable_name(CdfRecord& record) {
  std::string name(record.take(record.wide ? 256 : 64));
  name.resize(std::min(name.find('\0'), name.size()));
  while (!name.empty() && name.back() == ' ') name.pop_back();
  const auto control = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; };
  if (name.empty() || std::any_of(name.begin(), name.end(), control))
    throw Error(record.subject, "is damaged: a variable has no name that can be read");
  return name;
}

int64_t dimensions_of(int64_t count, const std::string& subject) {
  if (count < 0 || count > kMostCdfDimensions)
    throw Error(subject, "is damaged: " + std::to_string(count) + " dimensions");
  return count;
}

/// @param next set to where the next one is described, 0: nowhere
CdfVariable variable_at(const CdfFile& file, int64_t at, int64_t kind, int64_t& next) {
  CdfVariable out;
  CdfRecord record = record_of(file, at, kind);
  next = record.place();
  out.type = record.number();
  out.last_record = record.number();
  out.index = record.place();
  record.place();  // the last index
  const int64_t flags = record.number();
  out.sparse = record.number() != 0;
  record.take(12);
  out.elements = record.number();
  record.number();  // which one it is
  const int64_t packing = record.place();
  record.number();  // records that are made room for at once
  out.name = variable_name(record);
  out.varies = (flags & 1) != 0;
  if (!out.varies) out.last_record = std::min<int64_t>(out.last_record, 0);
  if ((flags & 4) != 0) out.packing = packing_at(file, packing);
  std::vector<int64_t> sizes = file.shared_shape;
  if (kind == kOwnVariable) {
    sizes.resize(static_cast<size_t>(dimensions_of(record.number(), file.subject)));
    for (int64_t& size : sizes) size = record.number();
  }
  for (const int64_t size : sizes)
    if (record.number() != 0) out.shape.push_back(size);  // else it is the same along this one
  return out;
}

struct CdfValues {
  const CdfVariable& variable;
  const std::string& subject;
  uint64_t record_bytes;
  std::string bytes;
  int64_t records = 0;  ///< in `bytes`
};

/// Adds the records that one block has.
void add_block(CdfFile& file, CdfRecord block, bool packed, int64_t last, CdfValues& to) {
  const uint64_t size =
      static_cast<uint64_t>(std::min(last, to.variable.last_record) - to.records + 1) * to.record_bytes;
  if (size > kMostCdfBytes - to.bytes.size()) throw Error(to.subject, "declares an absurd size");
  uint64_t there = size;
  if (packed) {
    block.take(4);
    there = static_cast<uint64_t>(block.place());
  }
  if (there > file.values_left) throw Error(to.subject, "is larger than the file");
  file.values_left -= there;
  if (there > block.left.size()) throw Error(to.subject, "ends early");
  const std::string_view bytes = block.take(there);
  if (packed)
    to.bytes += gunzipped(bytes, size, file.unpacked_left, to.subject);
  else
    to.bytes += bytes;
  to.records = last + 1;
}

/// Adds the records that an index leads to, blocks or further indices, and those of the indices behind it.
void add_index(CdfFile& file, int64_t at, int depth, CdfValues& to) {
  if (depth > kDeepestIndex) throw Error(to.subject, "is damaged: its index is too deep");
  while (at > 0) {
    visit(file, at);
    CdfRecord index = record_of(file, at, kVariableIndex);
    at = index.place();
    const int64_t entries = index.number(), used = index.number();
    const uint64_t width = file.wide ? 8 : 4;
    if (entries < 0 || used > entries || static_cast<uint64_t>(entries) > index.left.size() / (8 + width))
      throw Error(to.subject, "is damaged: its index is larger than the file");
    CdfRecord firsts = index, lasts = index, places = index;
    lasts.take(4 * static_cast<uint64_t>(entries));
    places.take(8 * static_cast<uint64_t>(entries));
    for (int64_t k = 0; k < used && to.records <= to.variable.last_record; ++k) {
      const int64_t first = firsts.number(), last = lasts.number(), place = places.place();
      if (last < to.records) continue;  // read by way of the index before, which may name the next one itself
      if (first != to.records) throw Error(to.subject, "is damaged: its records are in disorder");
      int64_t kind = 0;
      const CdfRecord block = any_record(file, place, kind);
      if (kind == kVariableIndex) {
        add_index(file, place, depth + 1, to);
      } else if (kind == kPlainValues || kind == kPackedValues) {
        add_block(file, block, kind == kPackedValues, last, to);
      } else {
        throw Error(to.subject, "is damaged: its index leads to a record of kind " + std::to_string(kind));
      }
    }
  }
}

/// Files the variable under its name: its numbers, or why it has none.
void add_variable(CdfFile& file, const CdfVariable& variable, Npz& to) {
  const std::string item = item_of(variable.type);
  std::string skipped;
  if (variable.type == 51 || variable.type == 52)
    skipped = "text";
  else if (item.empty() || variable.elements != 1)
    skipped = "of type " + std::to_string(variable.type);
  else if (variable.sparse)
    skipped = "an array of which records are left out";
  else if (variable.packing != 0 && variable.packing != kGzip)
    skipped = "packed by " + packing_name(variable.packing);
  else if (!variable.varies && variable.last_record < 0)
    skipped = "without a value";
  if (!skipped.empty()) {
    to.skipped.emplace(variable.name, skipped);
    return;
  }
  const std::string subject = file.subject + ": " + variable.name;
  uint64_t record_bytes = static_cast<uint64_t>(item[1] - '0');
  for (const int64_t size : variable.shape) {
    if (size < 1) throw Error(subject, "is damaged: a dimension of it is " + std::to_string(size));
    if (static_cast<uint64_t>(size) > kMostCdfBytes / record_bytes) throw Error(subject, "declares an absurd size");
    record_bytes *= static_cast<uint64_t>(size);
  }
  CdfValues values = {variable, subject, record_bytes, {}};
  if (variable.last_record >= 0) add_index(file, variable.index, 0, values);
  if (values.records <= variable.last_record)
    throw Error(subject, "ends early: " + std::to_string(variable.last_record + 1) + " records declared, " +
                             std::to_string(values.records) + " there");
  NpyHeader header;
  header.descr = (file.big_endian ? ">" : "<") + item;
  header.shape = variable.shape;
  if (file.column_major) std::reverse(header.shape.begin(), header.shape.end());
  if (variable.varies) header.shape.insert(header.shape.begin(), std::max<int64_t>(variable.last_record + 1, 0));
  std::string_view left = values.bytes;
  const ByteSource source = [&left](char* into, uint64_t size) {
    const size_t n = std::min<size_t>(size, left.size());
    std::memcpy(into, left.data(), n);
    left.remove_prefix(n);
    return static_cast<uint64_t>(n);
  };
  read_npy_data(source, values.bytes.size(), header, variable.name, subject, to);
  if (!file.column_major) return;
  torch::Tensor& tensor = to.tensors.at(variable.name);
  std::vector<int64_t> axes(header.shape.size());
  std::iota(axes.begin(), axes.end(), 0);
  std::reverse(axes.begin() + (variable.varies ? 1 : 0), axes.end());  // records lead in both orders
  tensor = tensor.permute(axes).contiguous();
}

/// Reads what holds for all variables. @param first_shared, first_own set to where the first of each kind is described
void read_descriptors(CdfFile& file, int64_t& first_shared, int64_t& first_own) {
  CdfRecord cdf = record_of(file, 8, kCdfDescriptor);
  const int64_t global_at = cdf.place();
  cdf.take(8);  // version and release
  const int64_t encoding = cdf.number(), flags = cdf.number();
  static const std::set<int64_t> big = {1, 2, 5, 7, 9, 11, 12, 18}, little = {4, 6, 13, 16, 17, 19};
  file.big_endian = big.count(encoding) != 0;
  file.column_major = (flags & 1) == 0;
  if (!file.big_endian && little.count(encoding) == 0)
    throw Error(file.subject, "has numbers in encoding " + std::to_string(encoding) + ", which is not read");
  if ((flags & 2) == 0) throw Error(file.subject, "has its variables in other files, which is not read");
  CdfRecord global = record_of(file, global_at, kGlobalDescriptor);
  first_shared = global.place();
  first_own = global.place();
  global.place();  // attributes
  global.place();  // the file's end
  global.take(12);
  const int64_t dimensions = dimensions_of(global.number(), file.subject);
  global.number();
  global.place();  // unused records
  global.take(12);
  for (int64_t k = 0; k < dimensions; ++k) file.shared_shape.push_back(global.number());
}

}  // namespace

Npz parse_cdf(std::string_view bytes, const std::string& subject) {
  if (bytes.empty()) throw Error(subject, "is empty");
  const std::string_view version = bytes.substr(0, 4), packed = bytes.substr(std::min<size_t>(bytes.size(), 4), 4);
  CdfFile file = {bytes, subject};
  file.wide = version == std::string_view("\xCD\xF3\x00\x01", 4);
  if ((!file.wide && version != std::string_view("\xCD\xF2\x60\x02", 4)) ||
      (packed != std::string_view("\x00\x00\xFF\xFF", 4) && packed != std::string_view("\xCC\xCC\x00\x01", 4)))
    throw Error(subject, "is no CDF file of version 2.6, 2.7 or 3");
  file.unpacked_left = kBestRatio * (bytes.size() + 64);
  std::string unpacked;
  if (packed[0] != '\0') {
    CdfRecord whole = record_of(file, 8, kPackedFile);
    const int64_t packing = packing_at(file, whole.place());
    if (packing != kGzip) throw Error(subject, "is packed by " + packing_name(packing) + ", which is not read");
    const auto size = static_cast<uint64_t>(whole.place());
    whole.take(4);
    unpacked = gunzipped(whole.left, size, file.unpacked_left, subject);
    unpacked.insert(0, bytes.substr(0, 8));  // places count from before them
    file.bytes = unpacked;
  }
  file.values_left = file.bytes.size();
  int64_t first_shared = 0, first_own = 0;
  read_descriptors(file, first_shared, first_own);
  Npz out;
  for (const auto& [first, kind] : {std::pair(first_shared, kSharedVariable), std::pair(first_own, kOwnVariable)})
    for (int64_t at = first, next = 0; at > 0; at = next) {
      visit(file, at);
      add_variable(file, variable_at(file, at, kind, next), out);
    }
  return out;
}

Npz read_cdf(const std::string& path) { return parse_cdf(read_whole_file(path), path); }

}  // namespace inhabit
