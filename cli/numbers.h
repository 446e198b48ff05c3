#pragma once
#include <cstddef>
#include <string>
#include <vector>

/// `count` finite numbers between commas. Throws inhabit::Error. @param option named in errors
std::vector<double> numbers(const std::string& text, size_t count, const std::string& option);
