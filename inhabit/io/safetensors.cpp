#include "inhabit/io/safetensors.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"

namespace inhabit {
namespace {

using nlohmann::json;

constexpr uint64_t kLargestHeader = 100'000'000;  // the format's own limit

const std::vector<std::pair<std::string, torch::ScalarType>>& element_types() {
  static const std::vector<std::pair<std::string, torch::ScalarType>> types{
      {"F64", torch::kFloat64}, {"F32", torch::kFloat32}, {"F16", torch::kFloat16}, {"BF16", torch::kBFloat16},
      {"I64", torch::kInt64},   {"I32", torch::kInt32},   {"I16", torch::kInt16},   {"I8", torch::kInt8},
      {"U8", torch::kUInt8},    {"BOOL", torch::kBool}};
  return types;
}

struct Entry {
  std::string name;
  torch::ScalarType type = torch::kFloat32;
  std::vector<int64_t> shape;
  uint64_t begin = 0, end = 0;  // bytes, from the end of the header
};

struct TensorsHeader {
  std::vector<Entry> entries;  // by place in the file
  std::map<std::string, std::string> metadata;
  uint64_t data_start = 0;
};

bool is_unsigned(const json& value) { return value.is_number_unsigned(); }

Entry parse_entry(const std::string& path, const std::string& name, const json& value) {
  const std::string subject = path + ": tensor '" + name.substr(0, 100) + "'";
  if (!value.is_object() || !value.contains("dtype") || !value.contains("shape") || !value.contains("data_offsets"))
    throw Error(subject, "header entry lacks dtype, shape or data_offsets");
  const json& dtype = value["dtype"];
  const json& shape = value["shape"];
  const json& offsets = value["data_offsets"];
  if (!dtype.is_string() || !shape.is_array() || shape.size() > 16 || !offsets.is_array() || offsets.size() != 2 ||
      !is_unsigned(offsets[0]) || !is_unsigned(offsets[1]))
    throw Error(subject, "malformed header entry");

  Entry entry;
  entry.name = name;
  bool known = false;
  for (const auto& [type_name, type] : element_types()) {
    if (dtype == type_name) {
      entry.type = type;
      known = true;
    }
  }
  if (!known) throw Error(subject, "unsupported element type '" + dtype.get<std::string>().substr(0, 20) + "'");

  const auto element = static_cast<uint64_t>(torch::elementSize(entry.type));
  uint64_t count = 1;
  for (const json& size : shape) {
    if (!is_unsigned(size)) throw Error(subject, "malformed shape");
    const auto n = size.get<uint64_t>();
    if (n > static_cast<uint64_t>(std::numeric_limits<int64_t>::max())) throw Error(subject, "absurd shape");
    if (n != 0 && count > std::numeric_limits<int64_t>::max() / element / n) throw Error(subject, "absurd shape");
    count *= n;
    entry.shape.push_back(static_cast<int64_t>(n));
  }
  entry.begin = offsets[0].get<uint64_t>();
  entry.end = offsets[1].get<uint64_t>();
  if (entry.begin > entry.end || entry.end - entry.begin != count * element)
    throw Error(subject, "data offsets disagree with the shape");
  return entry;
}

TensorsHeader parse_header(const std::string& path, std::ifstream& in, uint64_t file_size) {
  unsigned char prefix[8];
  if (file_size < 8 || !in.read(reinterpret_cast<char*>(prefix), 8))
    throw Error(path, "not a safetensors file (shorter than its header)");
  uint64_t length = 0;
  for (int i = 7; i >= 0; --i) length = (length << 8) | prefix[i];
  if (length > kLargestHeader || length > file_size - 8)
    throw Error(path, "not a safetensors file, or truncated (header length " + std::to_string(length) + ")");
  std::string text(length, '\0');
  if (!in.read(text.data(), static_cast<std::streamsize>(length))) throw Error(path, "cannot read the header");

  const json root = json::parse(text, nullptr, false);
  if (root.is_discarded() || !root.is_object()) throw Error(path, "not a safetensors file (header is not JSON)");

  TensorsHeader header;
  header.data_start = 8 + length;
  const uint64_t data_size = file_size - header.data_start;
  for (const auto& [name, value] : root.items()) {
    if (name == "__metadata__") {
      if (!value.is_object()) throw Error(path, "metadata is not a map of strings");
      for (const auto& [key, text_value] : value.items()) {
        if (!text_value.is_string()) throw Error(path, "metadata is not a map of strings");
        header.metadata[key] = text_value.get<std::string>();
      }
      continue;
    }
    header.entries.push_back(parse_entry(path, name, value));
    if (header.entries.back().end > data_size)
      throw Error(path + ": tensor '" + name.substr(0, 100) + "'", "lies outside the file (truncated?)");
  }
  std::sort(header.entries.begin(), header.entries.end(),
            [](const Entry& a, const Entry& b) { return std::tie(a.begin, a.end) < std::tie(b.begin, b.end); });
  for (size_t i = 1; i < header.entries.size(); ++i) {
    if (header.entries[i].begin < header.entries[i - 1].end)
      throw Error(path, "tensors '" + header.entries[i - 1].name.substr(0, 100) + "' and '" +
                            header.entries[i].name.substr(0, 100) + "' overlap");
  }
  return header;
}

std::ifstream open(const std::string& path, uint64_t& file_size) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code))
    throw Error(path, std::filesystem::exists(path, code) ? "not a file" : "no such file");
  file_size = std::filesystem::file_size(path, code);
  if (code) throw Error(path, code.message());
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(path, std::strerror(errno));
  return in;
}

}  // namespace

SafeTensors read_safetensors(const std::string& path) {
  uint64_t file_size = 0;
  std::ifstream in = open(path, file_size);
  TensorsHeader header = parse_header(path, in, file_size);
  SafeTensors content;
  content.metadata = std::move(header.metadata);
  for (const Entry& entry : header.entries) {
    torch::Tensor tensor = torch::empty(entry.shape, torch::TensorOptions().dtype(entry.type));
    const auto bytes = static_cast<std::streamsize>(entry.end - entry.begin);
    in.seekg(static_cast<std::streamoff>(header.data_start + entry.begin));
    if (bytes > 0 && !in.read(static_cast<char*>(tensor.data_ptr()), bytes))
      throw Error(path, "cannot read tensor '" + entry.name.substr(0, 100) + "'");
    if (entry.type == torch::kBool) {  // any byte but 0 and 1 would be undefined behaviour in a bool
      auto* byte = static_cast<unsigned char*>(tensor.data_ptr());
      for (std::streamsize i = 0; i < bytes; ++i) byte[i] = byte[i] != 0 ? 1 : 0;
    }
    content.tensors[entry.name] = tensor;
  }
  return content;
}

std::map<std::string, std::string> read_safetensors_metadata(const std::string& path) {
  uint64_t file_size = 0;
  std::ifstream in = open(path, file_size);
  return parse_header(path, in, file_size).metadata;
}

void write_safetensors(const std::string& path, const SafeTensors& content, bool half) {
  json root = json::object();
  if (!content.metadata.empty()) root["__metadata__"] = content.metadata;
  std::vector<torch::Tensor> stored;
  uint64_t offset = 0;
  for (const auto& [name, given] : content.tensors) {
    torch::Tensor tensor = given.detach().to(torch::kCPU).contiguous();
    if (half && (tensor.scalar_type() == torch::kFloat32 || tensor.scalar_type() == torch::kFloat64))
      tensor = tensor.to(torch::kFloat16);
    std::string type_name;
    for (const auto& [text, type] : element_types()) {
      if (type == tensor.scalar_type()) type_name = text;
    }
    if (type_name.empty()) throw Error(path, "cannot store tensor '" + name + "': unsupported element type");
    const auto bytes = static_cast<uint64_t>(tensor.numel()) * tensor.element_size();
    root[name] = {{"dtype", type_name}, {"shape", tensor.sizes().vec()}, {"data_offsets", {offset, offset + bytes}}};
    offset += bytes;
    stored.push_back(std::move(tensor));
  }
  std::string text = root.dump(-1, ' ', false, json::error_handler_t::replace);
  text.append((8 - text.size() % 8) % 8, ' ');  // data starts on a multiple of 8 bytes

  write_atomically(path, [&](std::ostream& out) {
    unsigned char prefix[8];
    for (int i = 0; i < 8; ++i) prefix[i] = static_cast<unsigned char>(text.size() >> (8 * i));
    out.write(reinterpret_cast<const char*>(prefix), 8);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    for (const torch::Tensor& tensor : stored)
      out.write(static_cast<const char*>(tensor.data_ptr()),
                static_cast<std::streamsize>(tensor.numel() * tensor.element_size()));
  });
}

}  // namespace inhabit
