#pragma once
#include <functional>
#include <ostream>
#include <string>
#include <string_view>

namespace inhabit {

/// Writes a file so that it is there whole or not at all: `write` fills a temporary beside `path`, which then takes the
/// target's name. An existing target that is no regular file (/dev/null, a pipe) is written in place.
/// Throws Error(path, ...) where the folder is missing, the file cannot be written or the disk is full; the temporary
/// is removed then, as also when `write` throws.
void write_atomically(const std::string& path, const std::function<void(std::ostream&)>& write);
/// Writes these bytes so that the file is there whole or not at all, as the other form does.
void write_atomically(const std::string& path, std::string_view bytes);

/// The whole file. Throws Error(path, ...) where it is missing, a folder, unreadable or larger than `limit` bytes.
std::string read_whole_file(const std::string& path, uint64_t limit = uint64_t{4} << 30);

}  // namespace inhabit
