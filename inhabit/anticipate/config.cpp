#include "inhabit/anticipate/config.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "inhabit/error.h"

namespace inhabit {
namespace {

using nlohmann::json;

/// Calls visit(key, field) for every field, so that reading and writing name each once.
template <class Config, class Visit>
void visit_fields(Config& c, const Visit& visit) {
  visit("rate", c.rate);
  visit("observed", c.observed);
  visit("future", c.future);
  visit("gamma", c.gamma);
  visit("rec_frames", c.rec_frames);
  visit("kappa", c.kappa);
  visit("labels", c.labels);
  visit("clusters", c.clusters);
  visit("naive_clusters", c.naive_clusters);
  visit("intention", c.intention);
  visit("label_adversary", c.label_adversary);
  visit("pose_adversary", c.pose_adversary);
  visit("intention_hidden", c.intention_hidden);
  visit("hidden", c.hidden);
  visit("noise", c.noise);
  visit("intention_features", c.intention_features);
  visit("adversary_hidden", c.adversary_hidden);
  visit("adversary_frames", c.adversary_frames);
  visit("adversary_weight", c.adversary_weight);
  visit("label_temperature", c.label_temperature);
  visit("label_adversary_weight", c.label_adversary_weight);
  visit("diversity_weight", c.diversity_weight);
  visit("seq2seq_hidden", c.seq2seq_hidden);
  visit("ltd_past", c.ltd_past);
  visit("ltd_future", c.ltd_future);
  visit("ltd_hidden", c.ltd_hidden);
  visit("ltd_blocks", c.ltd_blocks);
}

/// Sets a field; false where the value is of another type.
bool take(const json& value, bool& field) {
  if (!value.is_boolean()) return false;
  field = value.get<bool>();
  return true;
}
bool take(const json& value, int& field) {
  if (!value.is_number_integer()) return false;
  field = static_cast<int>(std::clamp(value.get<double>(), -1e9, 1e9));  // beyond what validate() lets through
  return true;
}
bool take(const json& value, double& field) {
  if (!value.is_number()) return false;
  field = value.get<double>();
  return true;
}

AnticipateConfig from(const json& root, AnticipateConfig config, const std::string& subject) {
  if (!root.is_object()) throw Error(subject, "the configuration is no JSON object");
  std::set<std::string> known;
  visit_fields(config, [&](const char* key, auto& field) {
    known.insert(key);
    if (!root.contains(key)) return;
    if (!take(root[key], field)) throw Error(subject, std::string("configuration: '") + key + "' has the wrong type");
  });
  for (const auto& [key, value] : root.items())
    if (known.count(key) == 0) throw Error(subject, "configuration: no setting is called '" + key.substr(0, 60) + "'");
  return config;
}

}  // namespace

std::string to_json(const AnticipateConfig& config) {
  nlohmann::ordered_json out;
  visit_fields(config, [&](const char* key, const auto& field) { out[key] = field; });
  return out.dump();
}

AnticipateConfig anticipate_config_from_json(const std::string& text, const std::string& subject) {
  const json root = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (root.is_discarded()) throw Error(subject, "the configuration is no JSON");
  const AnticipateConfig config = from(root, {}, subject);
  validate(config, subject);
  return config;
}

void set_field(AnticipateConfig& config, const std::string& setting) {
  const size_t at = setting.find('=');
  const json value = at == std::string::npos ? json() : json::parse(setting.substr(at + 1), nullptr, false);
  if (value.is_discarded() || value.is_null())
    throw Error(setting, "is no setting: KEY=VALUE, a number or true or false");
  config = from({{setting.substr(0, at), value}}, config, setting);
}

void validate(const AnticipateConfig& c, const std::string& subject) {
  const auto within = [&](const char* name, double value, double low, double high) {
    if (!(value >= low && value <= high))
      throw Error(subject, std::string("configuration: '") + name + "' is out of range");
  };
  within("rate", c.rate, 1, 240);
  within("kappa", c.kappa, 2, 240);
  within("observed", c.observed, c.kappa, 2000);
  within("future", c.future, c.kappa, 2000);
  within("gamma", c.gamma, 1, 200);
  within("rec_frames", c.rec_frames, 0, 2000);
  within("labels", c.labels, 1, 256);
  within("clusters", c.clusters, 1, 1024);
  for (const auto& [name, width] : {std::pair("intention_hidden", c.intention_hidden),
                                    {"hidden", c.hidden},
                                    {"adversary_hidden", c.adversary_hidden},
                                    {"intention_features", c.intention_features},
                                    {"seq2seq_hidden", c.seq2seq_hidden},
                                    {"ltd_hidden", c.ltd_hidden}})
    within(name, width, 1, 4096);
  within("noise", c.noise, 0, c.hidden - 1);
  // Judged from the last observed frames on, and in stretches of 30 frames of longer runs.
  within("adversary_frames", c.adversary_frames, 2, std::min({c.future, c.observed, 30}));
  within("adversary_weight", c.adversary_weight, 0, 1000);
  within("label_temperature", c.label_temperature, 0, 10);
  within("label_adversary_weight", c.label_adversary_weight, 0, 1000);
  within("diversity_weight", c.diversity_weight, 0, 1000);
  within("ltd_past", c.ltd_past, 1, c.observed);
  within("ltd_future", c.ltd_future, 1, c.future);
  within("ltd_blocks", c.ltd_blocks, 1, 64);
}

}  // namespace inhabit
