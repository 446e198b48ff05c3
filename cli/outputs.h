#pragma once
#include <string>

/// Throws inhabit::Error where a file cannot be written to `path` (no folder, a folder itself, no permission): for
/// verbs that would otherwise learn of it after long work, or with another output written already.
void require_writable(const std::string& path);
