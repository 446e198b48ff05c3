#include "inhabit/serve/live_page.h"

#include <nlohmann/json.hpp>

#include "inhabit/serve/live_template.h"
#include "inhabit/serve/poses.h"
#include "inhabit/view/page.h"

namespace inhabit::serve {

std::string live_page(const World& world) {
  Page page;
  page.title = world.scene.name.empty() ? "inhabit" : world.scene.name;
  page.scene = &world.scene;
  page.people.push_back({world.person, "person"});
  return page_text(page, "scene", live_template());
}

std::string greeting(const World& world, int recorded) {
  using nlohmann::json;
  json out = {{"event", "hello"}, {"rate", 30}, {"chairs", json::array()}, {"recorded", recorded}};
  for (const Seat& seat : world.seats) {
    const Eigen::Vector3d at = seat.chair.seat();
    out["chairs"].push_back(
        {{"name", seat.chair.name}, {"seat", {at.x(), at.y(), at.z()}}, {"heading", seat.chair.heading()}});
  }
  out["contacts"] = !world.interactor.engine().networks().contact.is_empty();
  out["forecast"] = world.forecaster.has_value();
  out["futures"] = world.anticipator.has_value();
  out["poses"] = world.inbetweener ? json(pose_names()) : json::array();
  return out.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace inhabit::serve
