#include "inhabit/interact/warnings.h"

#include <spdlog/fmt/fmt.h>

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
  return out;
}

}  // namespace inhabit::interact
