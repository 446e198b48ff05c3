#include "inhabit/io/gzip.h"

#include <zlib.h>

#include <limits>
#include <new>

#include "inhabit/error.h"

namespace inhabit {

std::string gzipped(const std::string& bytes) {
  z_stream stream{};
  constexpr int kGzip = 15 + 16;
  constexpr int kLevel = 6;  // with 9 a page of 50 futures takes twice as long for 2.6 % fewer bytes
  if (bytes.size() > std::numeric_limits<uInt>::max()) throw Error("more than 4 GiB cannot be packed");
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, kGzip, 9, Z_DEFAULT_STRATEGY) != Z_OK) throw std::bad_alloc();
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

}  // namespace inhabit
