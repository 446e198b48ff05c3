#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace inhabit {

/// `count` finite numbers between commas, with blanks around them or without. Throws Error(subject, ...) where one is
/// none, or there are more or fewer.
std::vector<double> listed_numbers(const std::string& text, size_t count, const std::string& subject);

}  // namespace inhabit
