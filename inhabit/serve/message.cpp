#include "inhabit/serve/message.h"

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "inhabit/error.h"

namespace inhabit::serve {
namespace {

using nlohmann::json;

constexpr double kFarthestNumber = 1000;
constexpr size_t kLongestName = 200;

[[noreturn]] void refuse(const std::string& reason) { throw Error("message", reason); }

const json& field(const json& from, const char* name) {
  const auto at = from.find(name);
  if (at == from.end()) refuse(std::string("has no \"") + name + "\"");
  return *at;
}

double number(const json& value, const char* name) {
  if (!value.is_number()) refuse(std::string(name) + " is no number");
  const auto x = value.get<double>();
  if (!(std::abs(x) <= kFarthestNumber)) refuse(std::string(name) + " is beyond 1000");
  return x;
}

template <int N>
Eigen::Matrix<double, N, 1> place(const json& from, const char* name) {
  const json& value = field(from, name);
  if (!value.is_array() || value.size() != N)
    refuse(std::string(name) + " is no list of " + std::to_string(N) + " numbers");
  Eigen::Matrix<double, N, 1> out;
  for (int i = 0; i < N; ++i) out[i] = number(value[static_cast<size_t>(i)], name);
  return out;
}

std::string name_of(const json& from, const char* name) {
  const json& value = field(from, name);
  if (!value.is_string() || value.get_ref<const std::string&>().size() > kLongestName)
    refuse(std::string(name) + " is no name");
  return value.get<std::string>();
}

bool flag(const json& from, const char* name) {
  const json& value = field(from, name);
  if (!value.is_boolean()) refuse(std::string(name) + " is neither true nor false");
  return value.get<bool>();
}

Touch touch(const json& m) {
  Touch out;
  const std::string hand = name_of(m, "hand");
  if (hand != "left" && hand != "right") refuse("hand is neither left nor right");
  out.hand = hand == "left" ? 0 : 1;
  if (!field(m, "at").is_null()) out.at = place<3>(m, "at");
  if (m.contains("chair")) out.chair = name_of(m, "chair");
  return out;
}

using Reader = std::function<Order(const json&)>;

const std::map<std::string, Reader>& readers() {
  static const std::map<std::string, Reader> all = {
      {"walk", [](const json& m) { return Walk{place<2>(m, "to")}; }},
      {"sit", [](const json& m) { return Sit{name_of(m, "chair")}; }},
      {"contact", touch},
      {"draw", [](const json&) { return Draw{}; }},
      {"stand", [](const json&) { return Stand{}; }},
      {"restart", [](const json&) { return Restart{}; }},
      {"record", [](const json& m) { return Record{flag(m, "on")}; }},
      {"forecast",
       [](const json& m) {
         return Look{Preview::forecast, flag(m, "on")};
       }},
      {"futures",
       [](const json& m) {
         return Look{Preview::futures, flag(m, "on")};
       }},
      {"pose",
       [](const json& m) {
         return Take{name_of(m, "pose"), place<2>(m, "at"), number(field(m, "heading"), "heading")};
       }},
  };
  return all;
}

}  // namespace

Message parse_message(std::string_view text) {
  json m;
  try {
    m = json::parse(text);
  } catch (const json::exception&) {  // also for numbers beyond a double
    refuse("is no JSON");
  }
  if (!m.is_object()) refuse("is no JSON object");
  Message out;
  if (const auto at = m.find("number"); at != m.end()) {
    if (!at->is_number_unsigned() || at->get<uint64_t>() > UINT32_MAX) refuse("number is no count");
    out.number = at->get<uint32_t>();
  }
  const auto reader = readers().find(name_of(m, "do"));
  if (reader == readers().end()) {
    std::string names;
    for (const auto& [name, ignored] : readers()) names += (names.empty() ? "" : ", ") + name;
    refuse("asks for what is not known; there are " + names);
  }
  out.order = reader->second(m);
  return out;
}

}  // namespace inhabit::serve
