#include "options.h"

#include "inhabit/io/json_text.h"

namespace inhabit::c {

using nlohmann::json;

Options::Options(const char* text) : object_(text == nullptr ? json::object() : parse_json(text, "options")) {
  if (!object_.is_object()) throw Error("options", "are no JSON object");
}

json Options::value(const char* key) {
  known_.insert(key);
  return object_.value(key, json());
}

void Options::finish() const {
  std::string all;
  for (const std::string& key : known_) all += (all.empty() ? "" : ", ") + key;
  for (const auto& [key, value] : object_.items())
    if (known_.count(key) == 0) throw Error("options", "\"" + key.substr(0, 64) + "\" is none of " + all);
}

void Options::read(const json& from, const char* key, bool& value) {
  if (!from.is_boolean()) throw Error(key, "is neither true nor false");
  value = from.get<bool>();
}

void Options::read(const json& from, const char* key, double& value) {
  if (!from.is_number()) throw Error(key, "is no number");
  value = from.get<double>();
}

void Options::read(const json& from, const char* key, int64_t& value) {
  if (!from.is_number_integer() || (from.is_number_unsigned() && from.get<uint64_t>() > INT64_MAX))
    throw Error(key, "is no whole number");
  value = from.get<int64_t>();
}

void Options::read(const json& from, const char* key, int& value) {
  int64_t wide = 0;
  read(from, key, wide);
  if (wide < INT32_MIN || wide > INT32_MAX) throw Error(key, "is out of range");
  value = static_cast<int>(wide);
}

void Options::read(const json& from, const char* key, uint64_t& value) {
  if (!from.is_number_unsigned()) throw Error(key, "is no whole number from 0 on");
  value = from.get<uint64_t>();
}

void Options::read(const json& from, const char* key, std::string& value) {
  if (!from.is_string()) throw Error(key, "is no text");
  value = from.get<std::string>();
}

}  // namespace inhabit::c
