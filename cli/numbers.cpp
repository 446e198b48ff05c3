#include "numbers.h"

#include <spdlog/fmt/fmt.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <sstream>

#include "inhabit/error.h"

std::vector<double> numbers(const std::string& text, size_t count, const std::string& option) {
  std::vector<double> out;
  std::stringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    double value = 0;
    if (!CLI::detail::lexical_cast(part, value) || !std::isfinite(value))
      throw inhabit::Error(option, "'" + part + "' is no number");
    out.push_back(value);
  }
  if (out.size() != count)
    throw inhabit::Error(option, fmt::format("has {} numbers, {} are wanted", out.size(), count));
  return out;
}
