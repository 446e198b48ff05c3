#pragma once
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

// A folder of small files in one fuzz input, for readers that find their way in a data set as its owners hand it out.

namespace inhabit {

struct NamedBytes {
  std::string name;        ///< of a file, or of an array in an archive
  std::string_view bytes;  ///< what it holds
};

/// The pieces of an input: name, zero byte, 32-bit length, bytes. A length beyond the end takes what is left.
inline std::vector<NamedBytes> pieces_of(std::string_view bytes) {
  std::vector<NamedBytes> pieces;
  for (size_t zero = 0; (zero = bytes.find('\0')) != std::string_view::npos && bytes.size() - zero > 4;) {
    uint32_t length = 0;
    std::memcpy(&length, bytes.data() + zero + 1, 4);
    NamedBytes piece = {std::string(bytes.substr(0, zero)), bytes.substr(zero + 5, length)};
    bytes.remove_prefix(zero + 5 + piece.bytes.size());
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

/// A zip archive that stores its entries: its checksums fit whatever they hold, so that mutations reach the reader.
/// libzip would refuse names that are there twice or are no text, which archives may have.
inline std::string stored_zip(const std::vector<NamedBytes>& entries) {
  std::string out, directory;
  const auto number = [](uint64_t n, int bytes) {
    std::string text;
    for (int k = 0; k < bytes; ++k, n >>= 8) text += static_cast<char>(n & 0xFF);
    return text;
  };
  for (const NamedBytes& entry : entries) {
    const auto* data = reinterpret_cast<const Bytef*>(entry.bytes.data());
    const std::string common = number(20, 2) + number(0, 8) +  // version, flags, stored, time and date
                               number(crc32(0, data, static_cast<uInt>(entry.bytes.size())), 4) +
                               number(entry.bytes.size(), 4) + number(entry.bytes.size(), 4) +
                               number(entry.name.size(), 2) + number(0, 2);
    directory += "PK\x01\x02" + number(20, 2) + common + number(0, 10) + number(out.size(), 4) + entry.name;
    out += "PK\x03\x04" + common + entry.name;
    out += entry.bytes;
  }
  return out + directory + "PK\x05\x06" + number(0, 4) + number(entries.size(), 2) + number(entries.size(), 2) +
         number(directory.size(), 4) + number(out.size(), 4) + number(0, 2);
}

/// True for a name that stays below its folder.
inline bool stays_below(const std::string& name) {
  const bool plain = name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./ ") ==
                     std::string::npos;
  return plain && !name.empty() && name.size() < 120 && name.front() != '/' && name.back() != '/' &&
         name.find("..") == std::string::npos && name.find("//") == std::string::npos;
}

/// Writes up to 40 files below a folder that is emptied first. What a .npz holds are pieces again: NAME.npy, the array.
inline void write_folder(const std::string& folder, std::string_view bytes) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::vector<NamedBytes> files = pieces_of(bytes);
  for (size_t k = 0; k < files.size() && k < 40; ++k) {
    if (!stays_below(files[k].name)) continue;
    const std::filesystem::path path = folder + "/" + files[k].name;
    std::error_code refused;  // a file where another file's folder should be
    std::filesystem::create_directories(path.parent_path(), refused);
    const bool archive = path.extension() == ".npz";
    const std::string packed = archive ? stored_zip(pieces_of(files[k].bytes)) : std::string();
    const std::string_view content = archive ? std::string_view(packed) : files[k].bytes;
    std::ofstream(path, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
  }
}

}  // namespace inhabit
