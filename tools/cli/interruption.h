// SIGINT and SIGTERM as a request to stop between two frames. A second signal ends the process at
// once, as if nothing had been caught.
#ifndef EGOSIEVE_TOOLS_CLI_INTERRUPTION_H_
#define EGOSIEVE_TOOLS_CLI_INTERRUPTION_H_

namespace egosieve::tools {

void CatchInterruptions();
bool InterruptionRequested();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_INTERRUPTION_H_
