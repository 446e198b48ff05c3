#include "inhabit/interact/warnings.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>

namespace inhabit::interact {

std::vector<std::string> warnings_of(const Result& result, double seconds) {
  std::vector<std::string> out;
  if (!result.seated) out.push_back(fmt::format("nobody sits on {} within {:g} s", result.chair.name, seconds));
  size_t wanted = 0, begun = 0;
  for (size_t k = 0; k < result.contacts.size(); ++k) {
    const auto& [left, right] = result.contacts[k];
    const auto& [left_error, right_error] = result.contact_error[k];
    if (left || right) ++wanted;
    if ((left && left_error) || (right && right_error)) ++begun;
  }
  if (begun < wanted) out.push_back(fmt::format("of {} contacts {} were begun within {:g} s", wanted, begun, seconds));
  constexpr double kShort = 0.5;  // metres: somebody who stands there covers the place
  if (result.walk_error && std::isinf(*result.walk_error))
    out.push_back(fmt::format("nobody gets up to walk off within {:g} s", seconds));
  else if (result.walk_error && *result.walk_error > kShort)
    out.push_back(fmt::format("ends {:.1f} m from the place to walk to, after {:g} s", *result.walk_error, seconds));
  return out;
}

}  // namespace inhabit::interact
