#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <torch/types.h>

#include "inhabit/io/gzip.h"

// Writes CDF files as NASA's "CDF Internal Format Description" has them, for tests of what reads them.

namespace inhabit {

/// How a file is written.
struct CdfForm {
  bool wide = true;             ///< version 3, else 2.6
  bool big_endian = false;      ///< encoding NETWORK, else IBMPC
  bool column_major = false;    ///< the first dimension of a record runs fastest
  bool pack_variables = false;  ///< by gzip
  bool pack_file = false;       ///< by gzip, all but the eight bytes that say so
  int64_t block = 0;            ///< records in a block of values; 0: all
  bool deep = false;            ///< an index of indices
};

/// A variable of a file.
struct CdfArray {
  std::string name;
  torch::Tensor values;  ///< (records, dimensions...)
  bool varies = true;    ///< from record to record; else there is one
  bool shared = false;   ///< of the older kind, all of which have the same dimensions
  int type = 0;          ///< what it says to be; 0: as its values are
};

inline std::string cdf_number(int64_t value, size_t width = 4) {
  std::string out(width, '\0');
  for (size_t k = width; k-- > 0; value >>= 8) out[k] = static_cast<char>(value & 0xFF);
  return out;
}

/// A record of a kind, its size before it.
inline std::string cdf_record(const CdfForm& form, int kind, const std::string& content) {
  const size_t width = form.wide ? 8 : 4;
  return cdf_number(static_cast<int64_t>(width + 4 + content.size()), width) + cdf_number(kind) + content;
}

inline int cdf_type(torch::ScalarType type) {
  return type == torch::kFloat32   ? 44
         : type == torch::kFloat64 ? 45
         : type == torch::kInt8    ? 1
         : type == torch::kInt16   ? 2
         : type == torch::kInt32   ? 4
         : type == torch::kInt64   ? 8
                                   : 11;
}

/// Records [first, last] as they stand in a file.
inline std::string cdf_values(const CdfForm& form, const torch::Tensor& values, int64_t first, int64_t last) {
  torch::Tensor rows = values.slice(0, first, last + 1);
  if (form.column_major) {
    std::vector<int64_t> axes = {0};
    for (int64_t k = rows.dim() - 1; k > 0; --k) axes.push_back(k);
    rows = rows.permute(axes);
  }
  rows = rows.contiguous();
  std::string bytes(static_cast<const char*>(rows.data_ptr()), rows.nbytes());
  const size_t width = rows.element_size();
  for (size_t at = 0; form.big_endian && at < bytes.size(); at += width)
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                 bytes.begin() + static_cast<std::ptrdiff_t>(at + width));
  return bytes;
}

inline std::string cdf_bytes(const std::vector<CdfArray>& arrays, const CdfForm& form = {}) {
  const size_t width = form.wide ? 8 : 4, name_size = form.wide ? 256 : 64;
  const auto place = [&](size_t at) { return cdf_number(static_cast<int64_t>(at), width); };
  std::string shared_sizes;
  int64_t shared_dimensions = 0;
  for (const CdfArray& array : arrays) {
    if (!array.shared) continue;
    shared_sizes.clear();
    shared_dimensions = array.values.dim() - 1;
    for (int64_t k = 1; k < array.values.dim(); ++k) shared_sizes += cdf_number(array.values.size(k));
  }
  const size_t cdf_size = 2 * width + 4 + 36 + 256, global_size = 6 * width + 36 + shared_sizes.size();
  const size_t begin = 8 + cdf_size + global_size;
  std::string rest;
  size_t next_shared = 0, next_own = 0;
  int64_t shared = 0, own = 0;
  for (const CdfArray& array : arrays) {
    const int64_t records = array.values.size(0), block = form.block > 0 ? form.block : std::max<int64_t>(records, 1);
    std::string firsts, lasts, places;
    int64_t blocks = 0;
    for (int64_t first = 0; first < records; first += block, ++blocks) {
      const int64_t last = std::min(first + block, records) - 1;
      firsts += cdf_number(first);
      lasts += cdf_number(last);
      places += place(begin + rest.size());
      const std::string values = cdf_values(form, array.values, first, last);
      const std::string packed = form.pack_variables ? gzipped(values) : "";
      rest += form.pack_variables ? cdf_record(form, 13, cdf_number(0) + place(packed.size()) + packed)
                                  : cdf_record(form, 7, values);
    }
    size_t index = begin + rest.size();
    rest += cdf_record(form, 6, place(0) + cdf_number(blocks) + cdf_number(blocks) + firsts + lasts + places);
    if (form.deep) {
      const std::string whole = cdf_record(
          form, 6, place(0) + cdf_number(1) + cdf_number(1) + cdf_number(0) + cdf_number(records - 1) + place(index));
      index = begin + rest.size();
      rest += whole;
    }
    const size_t packing = begin + rest.size();
    rest += cdf_record(form, 11, cdf_number(5) + cdf_number(0) + cdf_number(1) + cdf_number(6));
    std::string name = array.name;
    name.resize(name_size, '\0');
    const int type = array.type != 0 ? array.type : cdf_type(array.values.scalar_type());
    size_t& next = array.shared ? next_shared : next_own;
    int64_t& number = array.shared ? shared : own;
    std::string variable = place(next) + cdf_number(type) + cdf_number(records - 1) + place(records > 0 ? index : 0) +
                           place(records > 0 ? index : 0) +
                           cdf_number((array.varies ? 1 : 0) + (form.pack_variables ? 4 : 0)) + std::string(16, '\0') +
                           cdf_number(1) + cdf_number(number++) + place(packing) + cdf_number(0) + name;
    if (!array.shared) {
      variable += cdf_number(array.values.dim() - 1);
      for (int64_t k = 1; k < array.values.dim(); ++k) variable += cdf_number(array.values.size(k));
    }
    for (int64_t k = 1; k < array.values.dim(); ++k) variable += cdf_number(-1);
    next = begin + rest.size();
    rest += cdf_record(form, array.shared ? 3 : 8, variable);
  }
  const int flags = (form.column_major ? 0 : 1) + 2;
  const std::string descriptor = cdf_record(form, 1,
                                            place(8 + cdf_size) + cdf_number(form.wide ? 3 : 2) + cdf_number(6) +
                                                cdf_number(form.big_endian ? 1 : 6) + cdf_number(flags) +
                                                std::string(20, '\0') + std::string(256, ' '));
  const std::string global =
      cdf_record(form, 2,
                 place(next_shared) + place(next_own) + place(0) + place(begin + rest.size()) + cdf_number(shared) +
                     cdf_number(0) + cdf_number(0) + cdf_number(shared_dimensions) + cdf_number(own) + place(0) +
                     std::string(12, '\0') + shared_sizes);
  const std::string magic = form.wide ? std::string("\xCD\xF3\x00\x01", 4) : std::string("\xCD\xF2\x60\x02", 4);
  const std::string body = descriptor + global + rest;
  if (!form.pack_file) return magic + std::string("\x00\x00\xFF\xFF", 4) + body;
  const std::string packed = gzipped(body);
  const size_t whole = width + 4 + 2 * width + 4 + packed.size();
  return magic + std::string("\xCC\xCC\x00\x01", 4) +
         cdf_record(form, 10, place(8 + whole) + place(body.size()) + cdf_number(0) + packed) +
         cdf_record(form, 11, cdf_number(5) + cdf_number(0) + cdf_number(1) + cdf_number(6));
}

}  // namespace inhabit
