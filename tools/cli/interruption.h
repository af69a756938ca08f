// SIGINT and SIGTERM as a request to stop between two frames, from the program's first statement
// on: whatever a command is doing then, it ends with all that it wrote whole. A second one of the
// same kind ends the process at once, as if nothing had been caught; one of each does not, since
// a command passes a terminal's SIGINT on as SIGTERM to programs that have had it already.
#ifndef EGOSIEVE_TOOLS_CLI_INTERRUPTION_H_
#define EGOSIEVE_TOOLS_CLI_INTERRUPTION_H_

namespace egosieve::tools {

// Keeps the signals back. For what comes before main: the libraries' initialisers take longer than
// much of what a command does.
void HoldInterruptions();
// Catches them, and those that were kept back.
void CatchInterruptions();
bool InterruptionRequested();

// For commands that do not ask: the signals end the process again, at once where one has come.
void EndOnInterruptions();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_INTERRUPTION_H_
