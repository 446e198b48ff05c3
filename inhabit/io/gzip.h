#pragma once
#include <string>

namespace inhabit {

/// The bytes as a gzip file has them. Throws Error where they are beyond 4 GiB.
std::string gzipped(const std::string& bytes);

}  // namespace inhabit
