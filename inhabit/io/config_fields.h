#pragma once
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "inhabit/error.h"

// A configuration as a JSON object. Its fields are named once, in a function object `fields`: fields(config, visit)
// calls visit(key, field) for each. A key such as "training.batch" stands for the field "batch" of the object
// "training".

namespace inhabit {

/// Sets a field; false where the value is of another type. Whole numbers far out of range become what a configuration's
/// validate() refuses.
bool take(const nlohmann::json& value, std::string& field);
/// Sets a field from true or false; false for another value.
bool take(const nlohmann::json& value, bool& field);
/// Sets a field from a whole number, cut to within 1e9 of zero; false for another value.
bool take(const nlohmann::json& value, int& field);
/// Sets a field from any number; false for another value.
bool take(const nlohmann::json& value, double& field);
/// Sets a field from a list of whole numbers; false for another value, which may leave it filled in part.
bool take(const nlohmann::json& value, std::vector<int>& field);

/// The JSON object that a configuration's text is. Throws Error(subject, ...) for other text.
nlohmann::json config_object(const std::string& text, const std::string& subject);

/// "KEY=VALUE" as ("KEY", VALUE): a number, true, false, a list such as [1,2], or else a string. Throws Error naming
/// the setting where it is none.
std::pair<std::string, nlohmann::json> setting_of(const std::string& setting);

/// The value under a key in an object, "training.batch" in its object "training"; null where there is none.
nlohmann::json value_under(const nlohmann::json& object, const std::string& key);
/// Puts a value there.
void put_under(nlohmann::ordered_json& object, const std::string& key, const nlohmann::ordered_json& value);
/// Throws Error(subject, ...) where the object has a key that is not in `known`.
void refuse_unknown(const nlohmann::json& object, const std::set<std::string>& known, const std::string& subject);

/// All fields as an object, in their order, nested at the dots of their keys.
template <class Config, class Fields>
nlohmann::ordered_json fields_to_json(const Config& config, const Fields& fields) {
  nlohmann::ordered_json out;
  fields(config, [&](const char* key, const auto& field) { put_under(out, key, field); });
  return out;
}

/// Sets the fields that `object` holds. Throws Error(subject, ...) for values of another type and for keys that are
/// neither fields nor among `others`.
template <class Config, class Fields>
void fields_from_json(const nlohmann::json& object, const std::string& subject, const Fields& fields, Config& config,
                      std::set<std::string> others = {}) {
  fields(config, [&](const char* key, auto& field) {
    others.insert(key);
    const nlohmann::json value = value_under(object, key);
    if (!value.is_null() && !take(value, field))
      throw Error(subject, std::string("configuration: '") + key + "' has the wrong type");
  });
  refuse_unknown(object, others, subject);
}

/// Sets fields from text, "training.batch=64" each. Throws Error naming the setting for unknown keys and values of
/// another type; whether they fit together is for validate() to say when all are set.
template <class Config, class Fields>
void set_fields(const std::vector<std::string>& settings, const Fields& fields, Config& config) {
  for (const std::string& setting : settings) {
    const auto [key, value] = setting_of(setting);
    nlohmann::ordered_json object;
    put_under(object, key, value);
    fields_from_json(object, setting, fields, config);
  }
}

/// The configuration that a text describes; fields that it leaves out keep their defaults. Throws Error(subject, ...)
/// for what is no JSON object of such fields, and what validate(config, subject), declared beside Config, throws.
template <class Config, class Fields>
Config config_from_json(const std::string& text, const std::string& subject, const Fields& fields) {
  Config config;
  fields_from_json(config_object(text, subject), subject, fields, config);
  validate(config, subject);
  return config;
}

/// What validate() of a configuration checks with: throws Error(subject, ...) naming the field.
struct ConfigCheck {
  std::string subject;  ///< the file or argument it came from

  /// Throws where `good` is false.
  void holds(bool good, const std::string& name) const {
    if (!good) throw Error(subject, "configuration: '" + name + "' is out of range");
  }
  /// Throws where a value is not from `low` to `high`, or not a number.
  void within(const std::string& name, double value, double low, double high) const {
    holds(value >= low && value <= high, name);
  }
};

}  // namespace inhabit
