#pragma once
#include <stdexcept>
#include <string>

namespace inhabit {

/// The one exception of the project: what went wrong, with what, and where in it.
/// The command prints what() as one line on stderr and exits with code 2.
class Error : public std::runtime_error {
 public:
  /// @param subject the file (or argument) at fault; @param reason one clause, no newline.
  Error(const std::string& subject, const std::string& reason)
      : std::runtime_error(subject.empty() ? reason : subject + ": " + reason) {}
  /// Where nothing is to be named. @param reason one clause, no newline.
  explicit Error(const std::string& reason) : std::runtime_error(reason) {}
};

}  // namespace inhabit
