#pragma once
#include <string>

#include <gtest/gtest.h>

#include "inhabit/error.h"

/// The message of the inhabit::Error that `run` throws, which must be one line; empty where it throws none.
template <typename Run>
std::string refusal_of(const Run& run) {
  try {
    run();
  } catch (const inhabit::Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  return "";
}
