// The process's standard streams, at the start of the program.
//
// stderr is the program's own. Libraries (libpng, libjpeg, FFmpeg, PoCL, LLVM) print there, too:
// what they print is in our statuses already, or of no use. So descriptor 2 becomes a pipe that
// keeps the first 64 KiB and drops the rest, and std::cerr goes on to where stderr led.
//
// Where a library ends the process (abort, an exception that nobody catches), its last lines are
// reported as the program's one line, with what may help, and the exit code is 1.
//
// None of this where the environment has EGOSIEVE_LIBRARY_LINES, OPENCV_LOG_LEVEL,
// OPENCV_FFMPEG_LOGLEVEL or POCL_DEBUG: who asks for a library's lines gets them.
#ifndef EGOSIEVE_TOOLS_CLI_STANDARD_STREAMS_H_
#define EGOSIEVE_TOOLS_CLI_STANDARD_STREAMS_H_

namespace egosieve::tools {

// Before anything else in main. A standard descriptor that is closed is opened, so that no file of
// ours gets its number; writing to such a stdout fails.
void TakeStandardStreams();

// Once more after an OpenCL device has been opened: drivers bring LLVM, which catches aborts
// itself, to print the stack.
void WatchForAborts();

// The descriptor that std::cerr writes to.
int StderrDescriptor();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_STANDARD_STREAMS_H_
