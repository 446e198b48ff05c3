#pragma once
#include <cctype>
#include <charconv>
#include <string_view>

namespace inhabit {

/// Parses a whole token as a number ("1e-3", "+2", "nan"), without regard to the locale; false where it is none.
inline bool parse_number(std::string_view token, double& value) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  const auto [end, failed] = std::from_chars(token.data(), token.data() + token.size(), value);
  return failed == std::errc() && end == token.data() + token.size() && !token.empty();
}

/// Cuts the first line off `text` (without its line end, LF or CR LF).
inline std::string_view next_line(std::string_view& text) {
  const size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

/// Cuts the first white-space separated token off `text`; empty at the end.
inline std::string_view next_token(std::string_view& text) {
  size_t first = 0;
  while (first < text.size() && std::isspace(static_cast<unsigned char>(text[first])) != 0) ++first;
  size_t last = first;
  while (last < text.size() && std::isspace(static_cast<unsigned char>(text[last])) == 0) ++last;
  const std::string_view token = text.substr(first, last - first);
  text.remove_prefix(last);
  return token;
}

}  // namespace inhabit
