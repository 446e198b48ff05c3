#include "inhabit/interact/contact_script.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"

namespace inhabit::interact {
namespace {

std::optional<Eigen::Vector3d> three_numbers(const nlohmann::json& value) {
  const bool numbers = value.is_array() && value.size() == 3 &&
                       std::all_of(value.begin(), value.end(), [](const auto& v) { return v.is_number(); });
  if (!numbers) return std::nullopt;
  return Eigen::Vector3d(value[0].get<double>(), value[1].get<double>(), value[2].get<double>());
}

}  // namespace

ContactScript read_contact_script(const std::string& path, const Chair& chair) {
  return parse_contact_script(read_whole_file(path, uint64_t{1} << 24), path, chair);
}

ContactScript parse_contact_script(std::string_view text, const std::string& subject, const Chair& chair) {
  const auto script = parse_json(text, subject);
  if (!script.is_array() || script.empty()) throw Error(subject, "is no JSON list of contacts");
  ContactScript out;
  for (const auto& entry : script) {
    if (!entry.is_object()) throw Error(subject, "holds an entry that is no object with left, right or walk_to");
    if (out.then_walk) throw Error(subject, "walk_to is no last entry");
    if (entry.contains("walk_to")) {
      const auto place = three_numbers(entry["walk_to"]);
      if (!place || entry.size() != 1) throw Error(subject, "walk_to: is no [x, z, heading]");
      out.then_walk = Eigen::Vector3d(place->x(), place->y(), place->z() * M_PI / 180);
      continue;
    }
    for (const auto& [key, value] : entry.items())
      if (key != "left" && key != "right")
        throw Error(subject, "holds \"" + key + "\", which is none of left, right and walk_to");
    HandContacts contacts;
    for (int side = 0; side < 2; ++side) {
      const char* name = side == 0 ? "left" : "right";
      if (!entry.contains(name)) continue;
      try {
        contacts[static_cast<size_t>(side)] = contact_at(chair, contact_place(entry[name]), side);
      } catch (const Error& e) {
        throw Error(subject, std::string(name) + ": " + e.what());
      }
    }
    out.contacts.push_back(contacts);
  }
  return out;
}

ContactPlace contact_place(const nlohmann::json& value) {
  if (value.is_null()) return {};
  if (value.is_string()) return value.get<std::string>();
  const auto point = three_numbers(value);
  if (!point) throw Error("neither a part of the chair nor [x, y, z]");
  return *point;
}

nlohmann::json contacts_json(const std::vector<HandContacts>& contacts) {
  nlohmann::json out = nlohmann::json::array();
  for (const HandContacts& hands : contacts) {
    nlohmann::json entry = nlohmann::json::object();
    for (int side = 0; side < 2; ++side)
      if (const auto& c = hands[static_cast<size_t>(side)])
        entry[side == 0 ? "left" : "right"] = {c->x(), c->y(), c->z()};
    out.push_back(std::move(entry));
  }
  return out;
}

}  // namespace inhabit::interact
