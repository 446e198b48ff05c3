#pragma once
#include <cstdint>
#include <functional>
#include <string>

/// Logs "what: done of all" every ten seconds, for jobs that may be long.
std::function<void(int64_t done, int64_t all)> progress_lines(const std::string& what);
