// SIGINT and SIGTERM as a request to stop between two frames. They are caught from the program's
// first statement on, so that a command ends with complete files. A second signal of the same kind
// ends the process at once, with the signal's default action. One signal of each kind does not: a
// command passes a terminal's SIGINT on as SIGTERM to child programs that have already received
// SIGINT.
#pragma once

#include "absl/status/status.h"

namespace egosieve::tools {

// Blocks the signals. For the time before main: the initialisers of the libraries take longer than
// much of a command's work.
void HoldInterruptions();
// Catches the signals, also those that arrived while they were blocked.
void CatchInterruptions();
bool InterruptionRequested();
// Whether the status is what PoCL's compiler makes of a signal: it drops its files and fails.
bool IsInterruption(const absl::Status& status);

// For commands that do not ask InterruptionRequested(): the signals end the process again, at once
// if one has already arrived.
void EndOnInterruptions();

}  // namespace egosieve::tools
