#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace inhabit {

/// Whether values of a JSON text lie over 100 deep in each other. No file of ours has such; copying or writing them, of
/// which each level is a call, would end the process.
bool nested_too_deep(std::string_view text);

/// The JSON value that `text` is. Throws Error(subject, ...) with the line where it stops being JSON (RFC 8259, which
/// has neither NaN nor Infinity nor numbers beyond double), and for values that are nested_too_deep.
/// @tparam Json nlohmann::json, or nlohmann::ordered_json to keep the order of the text.
template <typename Json = nlohmann::json>
Json parse_json(std::string_view text, const std::string& subject);

}  // namespace inhabit
