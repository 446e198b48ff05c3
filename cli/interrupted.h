#pragma once
#include <string>

#include "inhabit/interruption.h"

/// From here on SIGINT and SIGTERM end the process with a line and exit code 130 or 143, unless they were to be
/// ignored.
void listen_for_interruptions();

/// While it lives, they end the work at its next interruption point (inhabit/interruption.h), so that what is finished
/// is kept; after three seconds without one, and when they come again, at once.
class GoesOnLater {
 public:
  /// @param how what is kept and how to go on: "clips that are made are kept, the same command makes the others"
  explicit GoesOnLater(const std::string& how);
  ~GoesOnLater();
  GoesOnLater(const GoesOnLater&) = delete;
  GoesOnLater& operator=(const GoesOnLater&) = delete;

 private:
  inhabit::Interruptible interruptible_;
};
