#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "inhabit/error.h"

namespace inhabit {

/// Sets fields of a model that is measured, "inference.guidance=0" each: those that begin as Config::used() says, which
/// are how it is used. Throws Error naming the setting for any other.
template <class Config>
void set_used(Config& config, const std::vector<std::string>& settings) {
  const std::vector<std::string> keys = Config::used();
  std::string there;
  for (const std::string& key : keys) there += (there.empty() ? "" : ", ") + key;
  for (const std::string& setting : settings)
    if (std::none_of(keys.begin(), keys.end(), [&](const auto& key) { return setting.rfind(key, 0) == 0; }))
      throw Error("--set " + setting, "is how the networks were made; eval may change " + there);
  set_fields(config, settings);
  validate(config, "--set");
}

}  // namespace inhabit
