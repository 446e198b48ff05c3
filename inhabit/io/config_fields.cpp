#include "inhabit/io/config_fields.h"

#include <algorithm>

#include "inhabit/io/json_text.h"

namespace inhabit {

using nlohmann::json;

bool take(const json& value, std::string& field) {
  if (!value.is_string()) return false;
  field = value.get<std::string>();
  return true;
}
bool take(const json& value, bool& field) {
  if (!value.is_boolean()) return false;
  field = value.get<bool>();
  return true;
}
bool take(const json& value, int& field) {
  if (!value.is_number_integer()) return false;
  field = static_cast<int>(std::clamp(value.get<double>(), -1e9, 1e9));
  return true;
}
bool take(const json& value, double& field) {
  if (!value.is_number()) return false;
  field = value.get<double>();
  return true;
}
bool take(const json& value, std::vector<int>& field) {
  if (!value.is_array()) return false;
  field.assign(value.size(), 0);
  for (size_t i = 0; i < field.size(); ++i)
    if (!take(value[i], field[i])) return false;
  return true;
}

json config_object(const std::string& text, const std::string& subject) {
  json root = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (root.is_discarded()) throw Error(subject, "the configuration is no JSON");
  if (!root.is_object()) throw Error(subject, "the configuration is no JSON object");
  if (nested_too_deep(text)) throw Error(subject, "the configuration has values over 100 deep in each other");
  return root;
}

std::pair<std::string, json> setting_of(const std::string& setting) {
  const size_t at = setting.find('=');
  if (at == std::string::npos || at == 0 || at + 1 == setting.size()) throw Error(setting, "is no setting: KEY=VALUE");
  const std::string text = setting.substr(at + 1);
  json value = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (value.is_discarded()) value = text;
  if (value.is_null() || value.is_object() || nested_too_deep(text)) throw Error(setting, "is no setting: KEY=VALUE");
  return {setting.substr(0, at), value};
}

json value_under(const json& object, const std::string& key) {
  const size_t dot = key.find('.');
  const auto found = object.find(key.substr(0, dot));
  if (found == object.end()) return {};
  if (dot == std::string::npos) return *found;
  return found->is_object() ? value_under(*found, key.substr(dot + 1)) : json();
}

void put_under(nlohmann::ordered_json& object, const std::string& key, const nlohmann::ordered_json& value) {
  const size_t dot = key.find('.');
  if (dot == std::string::npos)
    object[key] = value;
  else
    put_under(object[key.substr(0, dot)], key.substr(dot + 1), value);
}

void refuse_unknown(const json& object, const std::set<std::string>& known, const std::string& subject) {
  const auto refuse = [&](const std::string& key) {
    throw Error(subject, "configuration: no setting is called '" + key.substr(0, 60) + "'");
  };
  for (const auto& [key, value] : object.items()) {
    if (known.count(key) != 0) continue;
    if (!value.is_object()) refuse(key);
    for (const auto& [inner, ignored] : value.items()) {
      std::string path = key;
      path.append(".").append(inner);
      if (known.count(path) == 0) refuse(path);
    }
  }
}

}  // namespace inhabit
