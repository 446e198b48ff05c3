#pragma once
#include <functional>
#include <string>

namespace inhabit {

/// What `work` returns, done in a child process: for libraries that may abort or crash on a damaged file. The child is
/// a fork of this process, so `work` sees its memory, may not use LibTorch, and changes nothing here. Throws Error:
/// that of `work` (or its exception's text under `subject`), or one that says how the child ended, after a minute of
/// processor time at most.
std::string in_child(const std::string& subject, const std::function<std::string()>& work);

}  // namespace inhabit
