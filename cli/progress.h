#pragma once
#include <string>

#include "inhabit/progress.h"

/// Says on stderr how far a job is that may be long: on a terminal a bar with what is done, how fast and how long it
/// will take; elsewhere a line every ten seconds; with --quiet nothing. May be called by several threads.
/// @param what "rooms"
inhabit::Progress progress_of(const std::string& what);

/// Whether progress_of shows bars: on a terminal, without --quiet.
bool shows_bars();

/// Has what is logged written above a bar that stands.
void log_above_bars();

/// Removes a bar that stands: before anything else is said on the terminal.
void end_progress();

/// Whether --quiet is given.
bool is_quiet();
