#include "inhabit/io/utf8.h"

#include <algorithm>

namespace inhabit {
namespace {

constexpr uint32_t kBroken = 0xFFFD;

}  // namespace

void append_utf8(std::string& to, uint32_t code) {
  if (code < 0x80) {
    to += static_cast<char>(code);
  } else if (code < 0x800) {
    to += static_cast<char>(0xC0 | (code >> 6));
    to += static_cast<char>(0x80 | (code & 0x3F));
  } else if (code < 0x10000) {
    to += static_cast<char>(0xE0 | (code >> 12));
    to += static_cast<char>(0x80 | ((code >> 6) & 0x3F));
    to += static_cast<char>(0x80 | (code & 0x3F));
  } else if (code < 0x110000) {
    to += static_cast<char>(0xF0 | (code >> 18));
    to += static_cast<char>(0x80 | ((code >> 12) & 0x3F));
    to += static_cast<char>(0x80 | ((code >> 6) & 0x3F));
    to += static_cast<char>(0x80 | (code & 0x3F));
  } else {
    to += '?';
  }
}

std::vector<uint32_t> code_points(const std::string& text) {
  std::vector<uint32_t> codes;
  for (size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i++]);
    const int more = lead < 0x80 ? 0 : lead >> 5 == 6 ? 1 : lead >> 4 == 14 ? 2 : lead >> 3 == 30 ? 3 : -1;
    uint32_t code = more == 0 ? lead : lead & (0x3FU >> std::max(more, 0));
    bool whole = more >= 0;
    for (int k = 0; k < more && whole; ++k) {
      whole = i < text.size() && (static_cast<unsigned char>(text[i]) >> 6) == 2;
      if (whole) code = (code << 6) | (static_cast<unsigned char>(text[i++]) & 0x3F);
    }
    codes.push_back(whole ? code : kBroken);
  }
  return codes;
}

std::string as_utf8(const std::string& bytes) {
  const std::vector<uint32_t> codes = code_points(bytes);
  if (std::find(codes.begin(), codes.end(), kBroken) == codes.end()) return bytes;
  std::string out;
  for (const char byte : bytes) append_utf8(out, static_cast<unsigned char>(byte));
  return out;
}

}  // namespace inhabit
