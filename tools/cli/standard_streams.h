// The process's standard streams, at the start of the program.
//
// stderr is reserved for the program's own messages. Libraries (libpng, libjpeg, FFmpeg, PoCL,
// LLVM) print there, too, but their lines either repeat our statuses or are of no use. Therefore
// descriptor 2 becomes a pipe that keeps the first 64 KiB and drops the rest, and std::cerr writes
// to the original stderr.
//
// If a library ends the process (abort, an uncaught exception), its last lines are reported as the
// program's one line of error, with a hint, and the exit code is 1. After a fault of memory
// (SIGSEGV, SIGBUS) the line is told, too, and the process ends by that signal, with a core where
// the system makes one.
//
// All of this is off if the environment has EGOSIEVE_LIBRARY_LINES, OPENCV_LOG_LEVEL,
// OPENCV_FFMPEG_LOGLEVEL or POCL_DEBUG: the user then wants the libraries' lines.
#pragma once

namespace egosieve::tools {

// Called first in main. Opens standard descriptors that are closed, so that no file of the program
// gets their numbers; writing to such a stdout fails.
void TakeStandardStreams();

// Called again after an OpenCL device has been opened: drivers load LLVM, which installs its own
// handler of aborts to print the stack.
void WatchForAborts();

// The descriptor that std::cerr writes to.
int StderrDescriptor();

}  // namespace egosieve::tools
