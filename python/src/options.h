#pragma once
#include <map>
#include <set>

#include "calls.h"
#include "inhabit/error.h"

namespace inhabit::python {

/// What a user calls so. Throws Error(option, ...) that lists the names.
template <class Value>
Value named(const std::string& option, const std::string& name, const std::map<std::string, Value>& values) {
  const auto found = values.find(name);
  if (found != values.end()) return found->second;
  std::string names;
  for (const auto& [known, value] : values) names += (names.empty() ? "" : ", ") + known;
  throw Error(option, "is '" + name + "', which is none of " + names);
}

/// Options that only some calls take, by their names: what no call asked for is refused. Needs no GIL once it is made.
class Options {
 public:
  /// @param of what takes them, for errors
  Options(std::string of, const py::kwargs& given);

  bool has(const std::string& name) const { return given_.contains(name); }

  /// What is given, or `otherwise`.
  bool flag(const std::string& name, bool otherwise);
  std::string text(const std::string& name, const std::string& otherwise = "");
  /// Throws Error where the number is beyond `least` and `most`.
  double number(const std::string& name, double otherwise, double least, double most);
  int64_t whole(const std::string& name, int64_t otherwise, int64_t least, int64_t most);
  /// A list, or one for a list of one.
  std::vector<std::string> texts(const std::string& name, const std::vector<std::string>& otherwise = {});
  std::vector<int> wholes(const std::string& name, int64_t least, int64_t most);

  /// Throws Error naming an option that none of the calls above was for.
  void refuse_others() const;
  /// All of them, as text.
  std::string dump() const { return given_.dump(); }

 private:
  const nlohmann::json* find(const std::string& name);

  std::string of_;
  nlohmann::json given_ = nlohmann::json::object();
  std::set<std::string> known_;
};

}  // namespace inhabit::python
