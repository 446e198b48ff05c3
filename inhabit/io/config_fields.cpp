#include "inhabit/io/config_fields.h"

#include <algorithm>

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
  return root;
}

}  // namespace inhabit
