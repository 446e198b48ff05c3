#pragma once
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "inhabit/error.h"

// A configuration as a JSON object. Its fields are named once, in a function object `fields`: fields(config, visit)
// calls visit(key, field) for each.

namespace inhabit {

/// Sets a field; false where the value is of another type. Whole numbers far out of range become what a configuration's
/// validate() refuses.
bool take(const nlohmann::json& value, std::string& field);
bool take(const nlohmann::json& value, bool& field);
bool take(const nlohmann::json& value, int& field);
bool take(const nlohmann::json& value, double& field);
bool take(const nlohmann::json& value, std::vector<int>& field);

/// The JSON object that a configuration's text is. Throws Error(subject, ...) for other text.
nlohmann::json config_object(const std::string& text, const std::string& subject);

template <class Config, class Fields>
nlohmann::ordered_json fields_to_json(const Config& config, const Fields& fields) {
  nlohmann::ordered_json out;
  fields(config, [&](const char* key, const auto& field) { out[key] = field; });
  return out;
}

/// Sets the fields that `object` holds. Throws Error(subject, ...) for values of another type and for keys that are
/// neither fields nor among `others`.
template <class Config, class Fields>
void fields_from_json(const nlohmann::json& object, const std::string& subject, const Fields& fields, Config& config,
                      std::set<std::string> others = {}) {
  fields(config, [&](const char* key, auto& field) {
    others.insert(key);
    if (object.contains(key) && !take(object[key], field))
      throw Error(subject, std::string("configuration: '") + key + "' has the wrong type");
  });
  for (const auto& [key, value] : object.items())
    if (others.count(key) == 0) throw Error(subject, "configuration: no setting is called '" + key.substr(0, 60) + "'");
}

}  // namespace inhabit
