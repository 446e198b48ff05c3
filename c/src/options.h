#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>

#include "inhabit/error.h"

namespace inhabit::c {

/// The JSON object that a caller's options are: each key is asked for by name, and finish() refuses all others.
class Options {
 public:
  /// @param text NULL: none. Throws Error("options", ...) for what is no JSON object.
  explicit Options(const char* text);

  /// Sets `value` where the key is there. Throws Error(key, ...) for a value of another type.
  template <class T>
  void take(const char* key, T& value) {
    known_.insert(key);
    const auto found = object_.find(key);
    if (found != object_.end()) read(*found, key, value);
  }
  /// The value under a key, null where there is none.
  nlohmann::json value(const char* key);

  /// Throws Error naming a key that nobody asked for.
  void finish() const;

 private:
  static void read(const nlohmann::json& from, const char* key, bool& value);
  static void read(const nlohmann::json& from, const char* key, double& value);
  static void read(const nlohmann::json& from, const char* key, int& value);
  static void read(const nlohmann::json& from, const char* key, int64_t& value);
  static void read(const nlohmann::json& from, const char* key, uint64_t& value);
  static void read(const nlohmann::json& from, const char* key, std::string& value);
  template <class T>
  static void read(const nlohmann::json& from, const char* key, std::optional<T>& value) {
    T there{};
    read(from, key, there);
    value = there;
  }
  template <class T>
  static void read(const nlohmann::json& from, const char* key, std::vector<T>& value) {
    if (!from.is_array()) throw Error(key, "is no list");
    value.clear();
    for (const nlohmann::json& item : from) {
      T& one = value.emplace_back();
      read(item, key, one);
    }
  }

  nlohmann::json object_;
  std::set<std::string> known_;
};

}  // namespace inhabit::c
