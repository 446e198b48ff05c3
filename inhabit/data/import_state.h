#pragma once
#include <map>
#include <mutex>
#include <string>

#include "inhabit/data/shard.h"

namespace inhabit {

/// What an import must remember from run to run, FOLDER/import.json (import-2-of-8.json of a shard): the format, and
/// how far up the floor of each scene was in its source. Safe to use from several threads.
class ImportState {
 public:
  /// Throws Error(folder, ...) where the folder holds a data set that no import of this format began.
  ImportState(const std::string& folder, const std::string& format, const Shard& shard = {});

  /// Whether the floor of a scene is known.
  bool has_floor(const std::string& scene) const;
  double floor(const std::string& scene) const;             ///< metres
  void set_floor(const std::string& scene, double metres);  ///< written at once

 private:
  std::string path_, format_;
  mutable std::mutex mutex_;
  std::map<std::string, double> floors_;
};

}  // namespace inhabit
