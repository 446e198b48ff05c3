#include "inhabit/io/bytes.h"

#include <fstream>

#include "inhabit/error.h"

namespace inhabit {

std::string read_bytes(const std::string& path) {
  constexpr std::uintmax_t most = 4ULL << 30;
  std::error_code failed;
  if (std::filesystem::is_directory(path, failed)) throw Error(path, "is a folder, not a file");
  if (!std::filesystem::exists(path, failed)) throw Error(path, "no such file");
  const std::uintmax_t size = std::filesystem::file_size(path, failed);
  if (failed) throw Error(path, "not a regular file");
  if (size > most) throw Error(path, "larger than 4 GiB");
  std::ifstream file(path, std::ios::binary);
  std::string bytes(static_cast<size_t>(size), '\0');
  if (!file || !file.read(bytes.data(), static_cast<std::streamsize>(size))) throw Error(path, "cannot be read");
  return bytes;
}

std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  if (!extension.empty()) extension.erase(0, 1);
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace inhabit
