// What the machine can refuse: room for the results, a cache that is whole, threads. Each gives one
// line with the reason and exit code 1, or the signal where memory was reached for that is not
// there.
#include "tests/tools/end_to_end/machine.h"

#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "tests/tools/testing/patch_drive.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::StartsWith;

TEST_F(Machine, AStdoutThatTakesNothing) {
  for (const char* arguments : {"--help", "--version", "devices", "segment --print_config"}) {
    ExpectOneLine(Shell(absl::StrCat("\"$EGOSIEVE\" ", arguments, " > /dev/full")), "stdout");
    ExpectOneLine(Shell(absl::StrCat("\"$EGOSIEVE\" ", arguments, " >&-")), "stdout");
  }
  // Nothing to write, nothing lost; and an error keeps its code.
  EXPECT_EQ(Shell("\"$EGOSIEVE\" report /nowhere > /dev/full").code, 3);
}

TEST_F(Machine, AVideoForWhichThereIsNoRoom) {
  // Files of at most 50 KiB: enough for everything but the video.
  const ProgramOutcome outcome = Shell(
      absl::StrCat("trap '' XFSZ; ulimit -f 100; exec \"$EGOSIEVE\" synthesize --video --frames=40 "
                   "--width=320 --height=180 --progress=none --out=",
                   root_, "/drive > /dev/null"));
  ExpectOneLine(outcome, "free some space");
  EXPECT_FALSE(fs::exists(root_ + "/drive/scene.json"));
}

TEST_F(Machine, ADamagedCacheOfCompiledKernels) {
  if (ShowsLibraryLines()) GTEST_SKIP() << "EGOSIEVE_LIBRARY_LINES is set";
  WritePatchDrive(root_, SmallPatchDrive(3));
  const std::string cache = root_ + "/kcache";
  fs::create_directories(cache);
  setenv("POCL_CACHE_DIR", cache.c_str(), 1);
  setenv("EGOSIEVE_CACHE_DIR", (root_ + "/cache").c_str(), 1);
  const std::string segment = absl::StrCat("exec \"$EGOSIEVE\" segment ", root_,
                                           "/frames --budget=100 --progress=none --overwrite "
                                           "--out=",
                                           root_, "/run > /dev/null");
  ASSERT_EQ(Shell(segment).code, 0);
  int damaged = 0;
  for (const auto& entry : fs::recursive_directory_iterator(cache)) {
    if (!entry.is_regular_file()) continue;
    std::ofstream(entry.path()) << "garbage";
    ++damaged;
  }
  if (damaged == 0) GTEST_SKIP() << "this device keeps nothing in POCL_CACHE_DIR";
  ExpectOneLine(Shell(segment), cache);
  fs::remove_all(cache);
  EXPECT_EQ(Shell(segment).code, 0);
}

// What a library that reaches for memory it was refused, or that aborts, does to the program.
TEST_F(Machine, ASignalByWhichALibraryEndsTheProgram) {
  if (ShowsLibraryLines()) GTEST_SKIP() << "EGOSIEVE_LIBRARY_LINES is set";
  WritePatchDrive(root_, SmallPatchDrive(3));
  const std::string err = root_ + "/signal.txt";
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT}) {
    const pid_t process = StartProgram({"segment", root_ + "/frames", "--out=" + root_ + "/run",
                                        "--overwrite", "--budget=100", "--progress=none"},
                                       "/dev/null", err);
    WaitUntil([&] { return Catches(process, signal); });
    kill(process, signal);
    ProgramOutcome outcome{.code = WaitForProgram(process), .err = *ReadFile(err)};
    if (signal != SIGABRT) {
      EXPECT_EQ(outcome.code, 128 + signal) << "the shell sees the signal, the system makes a core";
      outcome.code = 1;
    }
    ExpectOneLine(outcome, "a library ended the program");
  }
}

// As LLVM, which has its own handler for SIGABRT from the moment that it is loaded.
TEST_F(Machine, ALibraryThatAbortsWithAHandlerOfItsOwn) {
  if (ShowsLibraryLines()) GTEST_SKIP() << "EGOSIEVE_LIBRARY_LINES is set";
  WritePatchDrive(root_, SmallPatchDrive(3));
  const std::string library = fs::absolute("tests/tools/end_to_end/libaborting.so").string();
  ExpectOneLine(Shell(absl::StrCat("LD_PRELOAD=", library, " \"$EGOSIEVE\" segment ", root_,
                                   "/frames --budget=100 --out=", root_, "/run > /dev/null")),
                "a library ended the program");
}

// libpng tells of a broken checksum on stderr by itself.
TEST_F(Machine, WhatLibrariesPrintIsNotPassedOn) {
  if (ShowsLibraryLines()) GTEST_SKIP() << "EGOSIEVE_LIBRARY_LINES is set";
  WritePatchDrive(root_, SmallPatchDrive(3));
  const std::string path = root_ + "/frames/000001.png";
  std::string bytes = *ReadFile(path);
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(path, std::ios::binary) << bytes;
  const ProgramOutcome outcome =
      Shell(absl::StrCat("exec \"$EGOSIEVE\" segment ", root_,
                         "/frames --budget=100 --progress=none --out=", root_, "/run > /dev/null"));
  EXPECT_EQ(outcome.code, 4);
  EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
  EXPECT_THAT(outcome.err, StartsWith("egosieve: warning: "));
}

}  // namespace
}  // namespace egosieve::tools
