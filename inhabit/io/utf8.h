#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace inhabit {

/// Appends a code point as UTF-8; '?' for what is none.
void append_utf8(std::string& to, uint32_t code);

/// Code points of UTF-8 text; a broken byte becomes U+FFFD.
std::vector<uint32_t> code_points(const std::string& text);

/// Text of a file that does not say how it is written: as it is where it is UTF-8, else read as Latin-1, which older
/// tools write.
std::string as_utf8(const std::string& bytes);

}  // namespace inhabit
