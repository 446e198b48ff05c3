#include "inhabit/forecast/forecast_page.h"

#include <spdlog/fmt/fmt.h>

namespace inhabit::forecast {

Page forecast_page(const Result& result, const std::string& title) {
  using Role = PagePerson::Role;
  Page page;
  page.title = title;
  page.note = std::string("Grey: the second that was observed. Blue: the next two seconds as predicted") +
              (result.hypotheses.empty() ? "." : ", in several ways.") + " Orange: what really happened.";
  page.scene = &result.scene;
  const double now = result.past.seconds();
  page.people.push_back({result.past, "observed", Role::past, 0, nullptr});
  if (result.truth) page.people.push_back({*result.truth, "truth", Role::truth, now, nullptr});
  if (result.hypotheses.empty())
    page.people.push_back({result.prediction, "prediction", Role::prediction, now, nullptr});
  for (const Hypothesis& one : result.hypotheses)
    page.people.push_back(
        {one.prediction, fmt::format("{:.0f} % likely", 100 * one.probability), Role::prediction, now, nullptr});
  page.contacts =
      PageContacts{result.forecast.points, result.forecast.contact_maps().clamp(0, 1), {}, result.prediction.rate, 0};
  return page;
}

}  // namespace inhabit::forecast
