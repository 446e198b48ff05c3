#include "options.h"

#include <spdlog/fmt/fmt.h>

#include "inhabit/error.h"

namespace inhabit::python {
namespace {

/// What JSON has no form for: arrays, NumPy's numbers, paths.
py::object plain_value(const py::object& value) {
  if (py::hasattr(value, "tolist")) return value.attr("tolist")();
  return py::module_::import("os").attr("fspath")(value);
}

int64_t checked_whole(const std::string& name, const nlohmann::json& value, int64_t least, int64_t most) {
  if (!value.is_number_integer()) throw Error(name, "is " + value.dump() + ", no whole number");
  const auto out = value.get<int64_t>();
  if (out >= least && out <= most) return out;
  if (most == INT64_MAX) throw Error(name, "is under " + std::to_string(least));
  throw Error(name, "is not from " + std::to_string(least) + " to " + std::to_string(most));
}

std::string checked_text(const std::string& name, const nlohmann::json& value) {
  if (!value.is_string()) throw Error(name, "is " + value.dump() + ", no text");
  return value.get<std::string>();
}

}  // namespace

Options::Options(std::string of, const py::kwargs& given) : of_(std::move(of)) {
  for (const auto& [key, value] : given) {
    const auto name = key.cast<std::string>();
    if (value.is_none()) continue;
    try {
      const py::object text =
          py::module_::import("json").attr("dumps")(value, "default"_a = py::cpp_function(plain_value));
      given_[name] = nlohmann::json::parse(text.cast<std::string>());
    } catch (const py::error_already_set&) {
      throw Error(name, "is of a type that is none of options: " + std::string(Py_TYPE(value.ptr())->tp_name));
    } catch (const nlohmann::json::exception&) {  // NaN
      throw Error(name, "is not finite");
    }
  }
}

const nlohmann::json* Options::find(const std::string& name) {
  known_.insert(name);
  const auto found = given_.find(name);
  return found == given_.end() ? nullptr : &*found;
}

bool Options::flag(const std::string& name, bool otherwise) {
  const nlohmann::json* value = find(name);
  if (value == nullptr) return otherwise;
  if (!value->is_boolean()) throw Error(name, "is " + value->dump() + ", neither True nor False");
  return value->get<bool>();
}

std::string Options::text(const std::string& name, const std::string& otherwise) {
  const nlohmann::json* value = find(name);
  return value == nullptr ? otherwise : checked_text(name, *value);
}

double Options::number(const std::string& name, double otherwise, double least, double most) {
  const nlohmann::json* value = find(name);
  if (value == nullptr) return otherwise;
  if (!value->is_number()) throw Error(name, "is " + value->dump() + ", no number");
  const auto out = value->get<double>();
  if (!(out >= least && out <= most)) throw Error(name, fmt::format("is not from {:g} to {:g}", least, most));
  return out;
}

int64_t Options::whole(const std::string& name, int64_t otherwise, int64_t least, int64_t most) {
  const nlohmann::json* value = find(name);
  return value == nullptr ? otherwise : checked_whole(name, *value, least, most);
}

std::vector<std::string> Options::texts(const std::string& name, const std::vector<std::string>& otherwise) {
  const nlohmann::json* value = find(name);
  if (value == nullptr) return otherwise;
  if (!value->is_array()) return {checked_text(name, *value)};
  std::vector<std::string> out;
  for (const nlohmann::json& one : *value) out.push_back(checked_text(name, one));
  return out;
}

std::vector<int> Options::wholes(const std::string& name, int64_t least, int64_t most) {
  const nlohmann::json* value = find(name);
  std::vector<int> out;
  if (value == nullptr) return out;
  for (const nlohmann::json& one : value->is_array() ? *value : nlohmann::json::array({*value}))
    out.push_back(static_cast<int>(checked_whole(name, one, least, most)));
  return out;
}

void Options::refuse_others() const {
  std::string all;
  for (const std::string& name : known_) all += (all.empty() ? "" : ", ") + name;
  for (const auto& [name, value] : given_.items())
    if (known_.count(name) == 0)
      throw Error(name, "is of no use to '" + of_ + "', which takes " + (all.empty() ? "no options" : all));
}

}  // namespace inhabit::python
