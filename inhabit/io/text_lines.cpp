#include "inhabit/io/text_lines.h"

#include <charconv>
#include <cmath>

#include "inhabit/error.h"

namespace inhabit {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

}  // namespace

TextLines::TextLines(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {
  if (text_.substr(0, 3) == "\xEF\xBB\xBF") text_.remove_prefix(3);  // byte-order mark
  if (text_.find('\0') != std::string_view::npos) throw Error(name_, "is binary, a text file is expected");
}

bool TextLines::next(std::string_view& line) {
  if (at_ >= text_.size()) return false;
  const size_t end = text_.find_first_of("\n\r", at_);
  line = text_.substr(at_, end == std::string_view::npos ? std::string_view::npos : end - at_);
  at_ = end == std::string_view::npos ? text_.size() : end + 1;
  if (end != std::string_view::npos && text_[end] == '\r' && at_ < text_.size() && text_[at_] == '\n') ++at_;
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  ++number_;
  return true;
}

bool TextLines::next_filled(std::string_view& line) {
  while (next(line))
    if (!line.empty()) return true;
  return false;
}

void TextLines::fail(const std::string& reason) const {
  throw Error(name_, "line " + std::to_string(number_) + ": " + reason);
}

double TextLines::real(std::string_view word) const {
  double value = 0;
  const std::string_view digits = word.substr(0, 1) == "+" ? word.substr(1) : word;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (end != digits.data() + digits.size() || digits.empty() || error == std::errc::invalid_argument) {
    if (word.find(',') != std::string_view::npos)
      fail(in_quotes(word) + " has a comma where a decimal point is expected");
    fail(in_quotes(word) + " is not a number");
  }
  if (error == std::errc::result_out_of_range) {
    // Too small counts as zero, as with any other reader; too large is an error.
    if (digits.find("e-") == std::string_view::npos && digits.find("E-") == std::string_view::npos)
      fail(in_quotes(word) + " is too large");
    return 0;
  }
  if (!std::isfinite(value)) fail(in_quotes(word) + " is not a finite number");
  return value;
}

long TextLines::whole(std::string_view word, long lowest, long highest) const {
  long value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty() || error == std::errc::invalid_argument)
    fail(in_quotes(word) + " is not a whole number");
  if (error == std::errc::result_out_of_range || value < lowest || value > highest)
    fail(in_quotes(word) + " is not in [" + std::to_string(lowest) + ", " + std::to_string(highest) + "]");
  return value;
}

std::string_view next_word(std::string_view& rest) {
  while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
  size_t n = 0;
  while (n < rest.size() && !is_blank(rest[n])) ++n;
  const std::string_view word = rest.substr(0, n);
  rest.remove_prefix(n);
  return word;
}

std::string in_quotes(std::string_view word) {
  std::string out = "'";
  for (const char c : word.substr(0, 40)) out += static_cast<unsigned char>(c) < 32 || c == 127 ? '?' : c;
  return out + (word.size() > 40 ? "...'" : "'");
}

}  // namespace inhabit
