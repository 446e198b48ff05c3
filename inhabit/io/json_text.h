#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace inhabit {

/// The JSON value that `text` is. Throws Error(subject, ...) with the line where it stops being JSON (RFC 8259, which
/// has neither NaN nor Infinity nor numbers beyond double).
/// @tparam Json nlohmann::json, or nlohmann::ordered_json to keep the order of the text.
template <typename Json = nlohmann::json>
Json parse_json(std::string_view text, const std::string& subject);

}  // namespace inhabit
