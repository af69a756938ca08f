#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "kernels/base/kept_memory.h"
#include "kernels/runtime/driver_check.h"
#include "tools/build_description/build_description.h"
#include "tools/cli/command.h"
#include "tools/cli/command_line.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/interruption.h"
#include "tools/cli/standard_streams.h"
#include "tools/cli/threads_flag.h"
#include "tools/cli/version.h"

namespace egosieve::tools {
namespace {

// Called before the initialisers of all libraries.
void BeforeLibraries(int /*argc*/, char** /*argv*/, char** /*environment*/) { HoldInterruptions(); }
[[gnu::section(".preinit_array"),
  gnu::used]] void (*const before_libraries)(int, char**, char**) = BeforeLibraries;

int RunCommandLine(int argc, char** argv) {
  CommandLine line(
      "egosieve",
      "Finds, in video from one uncalibrated moving camera, the pixels of what moves by itself.",
      kVersion, BuildDescription());
  line.Add(MakeRunCommand());
  line.Add(MakeSegmentCommand());
  line.Add(MakeMergeCommand());
  line.Add(MakeBatchCommand());
  line.Add(MakeSynthesizeCommand());
  line.Add(MakeRefineCommand());
  line.Add(MakeMasksCommand());
  line.Add(MakePointsCommand());
  line.Add(MakeRenderCommand());
  line.Add(MakeReportCommand());
  line.Add(MakeDevicesCommand());
  line.Add(MakeTuneCommand());
  return line.Run({argv + 1, argv + argc}, std::cout, std::cerr);
}

}  // namespace
}  // namespace egosieve::tools

int main(int argc, char** argv) {
  egosieve::kernels::KeepFreedMemory();
  egosieve::kernels::LetPoclWrite();
  egosieve::tools::TakeStandardStreams();
  egosieve::tools::CatchInterruptions();
  egosieve::tools::ThreadsFlag().Apply();  // also for commands without this flag
  const int code = egosieve::tools::RunCommandLine(argc, argv);
  // Skips the libraries' handlers at exit: that of OpenBLAS would wait forever for threads that
  // wait for memory.
  std::_Exit(code);
}
