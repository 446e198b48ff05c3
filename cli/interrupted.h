#pragma once
#include <string>

#include "inhabit/interruption.h"

/// From here on a line is said before SIGINT and SIGTERM end the process, unless they were to be ignored.
void listen_for_interruptions();

/// Ends the process by the signal that ended the work of a GoesOnLater; returns where none did.
void end_if_interrupted();

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
