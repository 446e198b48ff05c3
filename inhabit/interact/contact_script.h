#pragma once
#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "inhabit/interact/chair.h"
#include "inhabit/interact/contact_area.h"
#include "inhabit/interact/live_person.h"

namespace inhabit::interact {

/// A series of contacts, each reached for once the one before was held, and where the person goes in the end.
struct ContactScript {
  std::vector<HandContacts> contacts;        ///< in the order in which they are reached for, world
  std::optional<Eigen::Vector3d> then_walk;  ///< x, z in metres, heading in radians from +Z towards +X
};

/// A file of contacts, JSON (docs/interaction.md): [{"left": "armrest", "right": [x, y, z]}, ..., {"walk_to": [x, z,
/// degrees]}], a part of the chair by name (contact_on) or a point in metres; "none", null or no entry leave a hand
/// free; walk_to may be the last entry. Throws Error(path, ...), and what contact_on throws.
ContactScript read_contact_script(const std::string& path, const Chair& chair);

/// The same from memory; `subject` names the source in errors.
ContactScript parse_contact_script(std::string_view text, const std::string& subject, const Chair& chair);

/// One hand's entry of such a file: null, a part of the chair, or [x, y, z]. Throws Error for anything else.
ContactPlace contact_place(const nlohmann::json& value);

/// Contacts as such a file has them: points in metres, no entry for a hand that is free.
nlohmann::json contacts_json(const std::vector<HandContacts>& contacts);

}  // namespace inhabit::interact
