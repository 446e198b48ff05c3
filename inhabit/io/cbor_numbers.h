#pragma once
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

namespace inhabit {

/// Numbers as the bytes that they have in memory, for JSON that is CBOR (between processes of one machine).
template <typename T>
nlohmann::json bytes_of(const std::vector<T>& numbers) {
  const auto* bytes = reinterpret_cast<const uint8_t*>(numbers.data());
  return nlohmann::json::binary(std::vector<uint8_t>(bytes, bytes + numbers.size() * sizeof(T)));
}

/// Numbers of bytes_of again; a rest shorter than a number is dropped. Throws nlohmann's type_error for another value.
template <typename T>
std::vector<T> numbers_of(const nlohmann::json& value) {
  const auto& bytes = value.get_binary();
  std::vector<T> out(bytes.size() / sizeof(T));
  if (!out.empty()) std::memcpy(out.data(), bytes.data(), out.size() * sizeof(T));
  return out;
}

}  // namespace inhabit
