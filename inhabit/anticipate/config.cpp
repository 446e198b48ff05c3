#include "inhabit/anticipate/config.h"

#include <algorithm>

#include "inhabit/error.h"
#include "inhabit/io/config_fields.h"

namespace inhabit::anticipate {
namespace {

using nlohmann::json;

constexpr auto fields = [](auto& c, const auto& visit) {
  visit("rate", c.rate);
  visit("observed", c.observed);
  visit("future", c.future);
  visit("label_frames", c.label_frames);
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
};

}  // namespace

std::string to_json(const Config& config) { return fields_to_json(config, fields).dump(); }

Config config_from_json(const std::string& text, const std::string& subject) {
  Config config;
  fields_from_json(config_object(text, subject), subject, fields, config);
  validate(config, subject);
  return config;
}

void set_field(Config& config, const std::string& setting) {
  const size_t at = setting.find('=');
  const json value = at == std::string::npos ? json() : json::parse(setting.substr(at + 1), nullptr, false);
  if (value.is_discarded() || value.is_null())
    throw Error(setting, "is no setting: KEY=VALUE, a number or true or false");
  fields_from_json({{setting.substr(0, at), value}}, setting, fields, config);
}

void validate(const Config& c, const std::string& subject) {
  const auto within = [&](const char* name, double value, double low, double high) {
    if (!(value >= low && value <= high))
      throw Error(subject, std::string("configuration: '") + name + "' is out of range");
  };
  within("rate", c.rate, 1, 240);
  within("kappa", c.kappa, 2, 240);
  within("observed", c.observed, c.kappa, 2000);
  within("future", c.future, c.kappa, 2000);
  within("label_frames", c.label_frames, 1, 2000);
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

}  // namespace inhabit::anticipate
