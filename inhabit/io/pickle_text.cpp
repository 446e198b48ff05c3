#include <array>
#include <charconv>
#include <limits>

#include "inhabit/io/number_text.h"
#include "inhabit/io/pickle_machine.h"

namespace inhabit {

/// A whole number as text, "12" or "12L".
void PickleMachine::push_decimal(std::string text) {
  if (!text.empty() && text.back() == 'L') text.pop_back();
  const bool negative = !text.empty() && text[0] == '-';
  int64_t value = 0;
  const size_t first = negative ? 1 : 0;
  if (text.size() == first) damaged("a wrong number");
  for (size_t i = first; i < text.size(); ++i) {
    if (text[i] < '0' || text[i] > '9') damaged("a wrong number");
    if (value > (std::numeric_limits<int64_t>::max() - 9) / 10) throw Error(subject_, "has a number beyond 64 bits");
    value = 10 * value + (text[i] - '0');
  }
  push_whole(negative ? -value : value);
}

/// A whole number of `count` bytes, two's complement.
void PickleMachine::push_long(uint64_t count) {
  const std::string_view raw = take(count);
  uint64_t value = 0;
  const bool negative = !raw.empty() && (static_cast<unsigned char>(raw.back()) & 0x80) != 0;
  for (size_t i = 0; i < raw.size(); ++i) {
    const auto byte = static_cast<unsigned char>(raw[i]);
    if (i >= 8 && byte != (negative ? 0xFF : 0)) throw Error(subject_, "has a number beyond 64 bits");
    if (i < 8) value |= static_cast<uint64_t>(byte) << (8 * i);
  }
  if (negative && raw.size() < 8) value |= ~uint64_t{0} << (8 * raw.size());
  if (raw.size() > 8 && (value >> 63 != 0) != negative) throw Error(subject_, "has a number beyond 64 bits");
  push_whole(static_cast<int64_t>(value));
}

/// A text as Python 2 writes it in its source: 'a\x00\n'.
std::string PickleMachine::unquoted(const std::string& quoted) const {
  if (quoted.size() < 2 || (quoted[0] != '\'' && quoted[0] != '"') || quoted.back() != quoted[0])
    damaged("a text without quotes");
  static constexpr std::string_view kLetters = "abtnvfr", kMeant = "\a\b\t\n\v\f\r";
  const auto hex = [](char c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1; };
  std::string out;
  for (size_t i = 1; i + 1 < quoted.size(); ++i) {
    if (quoted[i] != '\\') {
      out += quoted[i];
      continue;
    }
    const char c = quoted[++i];
    if (i + 1 >= quoted.size()) damaged("a wrong escape in a text");
    if (const size_t letter = kLetters.find(c); letter != std::string_view::npos) {
      out += kMeant[letter];
    } else if (c == 'x') {
      if (i + 3 >= quoted.size() || hex(quoted[i + 1]) < 0 || hex(quoted[i + 2]) < 0)
        damaged("a wrong escape in a text");
      out += static_cast<char>(hex(quoted[i + 1]) * 16 + hex(quoted[i + 2]));
      i += 2;
    } else {
      out += c;  // a quote or a backslash
    }
  }
  return out;
}

/// A text of protocol 0: code points below 256 as they are, others, zeros and ends of lines as \\u0000.
std::string PickleMachine::unescaped(const std::string& raw) const {
  std::string out;
  const auto add = [&out](uint32_t code) {  // as UTF-8
    const int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static constexpr std::array<uint32_t, 4> kLead = {0, 0xC0, 0xE0, 0xF0};
    out += static_cast<char>(kLead[static_cast<size_t>(more)] | (code >> (6 * more)));
    for (int k = more - 1; k >= 0; --k) out += static_cast<char>(0x80 | ((code >> (6 * k)) & 0x3F));
  };
  for (size_t i = 0; i < raw.size(); ++i) {
    const bool escaped = raw[i] == '\\' && i + 1 < raw.size() && (raw[i + 1] == 'u' || raw[i + 1] == 'U');
    if (!escaped) {
      add(static_cast<unsigned char>(raw[i]));
      continue;
    }
    const size_t digits = raw[i + 1] == 'u' ? 4 : 8;
    uint32_t code = 0;
    const char* first = raw.data() + i + 2;
    if (i + 2 + digits > raw.size() || std::from_chars(first, first + digits, code, 16).ptr != first + digits ||
        code >= 0x110000)
      damaged("a wrong escape in a text");
    add(code);
    i += 1 + digits;
  }
  return out;
}

void PickleMachine::step_text(unsigned char op) {
  switch (op) {
    case 'I': {
      const std::string text = line();
      return text == "00" || text == "01" ? push_boolean(text == "01") : push_decimal(text);
    }
    case 'L':
      return push_decimal(line());
    case 'F': {
      double real = 0;
      if (!parse_number(line(), real)) damaged("a wrong number");
      return push_real(real);
    }
    case 'S':
      return push_text(Kind::text, unquoted(line()));
    case 'V':
      return push_text(Kind::text, unescaped(line()));
    case 'c': {
      const std::string module = line();
      return global(module, line());
    }
    case 'p':
      return remember(key_of_line());
    case 'g':
      return recall(key_of_line());
    case 'P':
    case 'Q':
      throw Error(subject_, "refers to something outside of it");
    case 'i': {
      const std::string module = line();
      return global(module, line() + " (an object of a class)");
    }
    default: {
      static constexpr char kDigits[] = "0123456789abcdef";
      damaged(std::string("unknown instruction 0x") + kDigits[op >> 4] + kDigits[op & 15]);
    }
  }
}

}  // namespace inhabit
