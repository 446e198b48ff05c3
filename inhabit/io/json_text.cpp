#include "inhabit/io/json_text.h"

#include <algorithm>

#include "inhabit/error.h"

namespace inhabit {

bool nested_too_deep(std::string_view text) {
  constexpr int kDeepest = 100;
  int depth = 0;
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"')
      quoted = !quoted;
    else if (quoted)
      i += c == '\\' ? 1 : 0;  // and what it escapes
    else if (c == '[' || c == '{')
      ++depth;
    else if (c == ']' || c == '}')
      --depth;
    if (depth > kDeepest) return true;
  }
  return false;
}

template <typename Json>
Json parse_json(std::string_view text, const std::string& subject) {
  if (text.empty()) throw Error(subject, "is empty, not JSON");
  try {
    Json value = Json::parse(text.begin(), text.end());
    if (nested_too_deep(text)) throw Error(subject, "has values over 100 deep in each other");
    return value;
  } catch (const nlohmann::json::parse_error& e) {
    const std::string_view before = text.substr(0, std::min<size_t>(e.byte == 0 ? 0 : e.byte - 1, text.size()));
    // Of a text of one line, which may be one of many of a stream, no line is named.
    const bool lines = text.substr(0, text.size() - 1).find('\n') != std::string_view::npos;
    const std::string line =
        lines ? "line " + std::to_string(1 + std::count(before.begin(), before.end(), '\n')) + " " : "";
    if (before.size() == text.size())
      throw Error(subject, "is JSON that is cut short" + (lines ? ", at " + line.substr(0, line.size() - 1) : ""));
    const std::string_view rest = text.substr(before.size());
    const bool number = rest.rfind("NaN", 0) == 0 || rest.rfind("Infinity", 0) == 0;
    throw Error(subject, line + (number ? "has NaN or Infinity, which are no JSON" : "is not JSON"));
  } catch (const nlohmann::json::out_of_range&) {
    throw Error(subject, "has a number that is too large");
  }
}

template nlohmann::json parse_json(std::string_view, const std::string&);
template nlohmann::ordered_json parse_json(std::string_view, const std::string&);

}  // namespace inhabit
