#include "inhabit/io/number_list.h"

#include <cmath>
#include <sstream>
#include <string_view>

#include "inhabit/error.h"
#include "inhabit/io/number_text.h"

namespace inhabit {

std::vector<double> listed_numbers(const std::string& text, size_t count, const std::string& subject) {
  std::vector<double> out;
  std::stringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    std::string_view rest = part;
    double value = 0;
    if (!parse_number(next_token(rest), value) || !next_token(rest).empty() || !std::isfinite(value))
      throw Error(subject, "'" + part + "' is no number");
    out.push_back(value);
  }
  if (out.size() != count)
    throw Error(subject, "has " + std::to_string(out.size()) + " numbers, " + std::to_string(count) + " are wanted");
  return out;
}

}  // namespace inhabit
