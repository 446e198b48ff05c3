#pragma once
#include <string>

#include <gtest/gtest.h>

/// `text` with the first `what`, which must be there, as `by`.
inline std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}
