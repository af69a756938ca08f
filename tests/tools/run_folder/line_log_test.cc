#include "tools/run_folder/line_log.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "gtest/gtest.h"
#include "tests/testing/status.h"
#include "tests/tools/testing/fresh_folder.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

// A limit on the file size stands for a full disk: the write fails after a part of the bytes.
template <typename Body>
int ExitCodeUnderFileSizeLimit(rlim_t bytes, const Body& body) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
    _exit(body() ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(LineLog, GrowsByWholeLines) {
  const std::string path = FreshFolder() + "/log";
  {
    LineLog log = Value(LineLog::Open(path));
    ASSERT_TRUE(log.Append("one").ok());
    ASSERT_TRUE(log.Append("two").ok());
  }
  EXPECT_EQ(*ReadFile(path), "one\ntwo\n");
}

TEST(LineLog, CutsOffWhatACrashLeft) {
  const std::string path = FreshFolder() + "/log";
  std::ofstream(path) << "one\ntwo\nthr";
  ASSERT_TRUE(LineLog::Open(path)->Append("three").ok());
  EXPECT_EQ(*ReadFile(path), "one\ntwo\nthree\n");
  ASSERT_TRUE(LineLog::OpenTruncated(path, 1)->Append("zwei").ok());
  EXPECT_EQ(*ReadFile(path), "one\nzwei\n");
  EXPECT_EQ(LineLog::OpenTruncated(path, 3).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(*ReadFile(path), "one\nzwei\n");
}

TEST(LineLog, AFullDiskLeavesWholeLines) {
  const std::string path = FreshFolder() + "/log";
  EXPECT_EQ(ExitCodeUnderFileSizeLimit(100,
                                       [&] {
                                         absl::StatusOr<LineLog> log = LineLog::Open(path);
                                         return log->Append(std::string(60, 'a')).ok() &&
                                                !log->Append(std::string(60, 'b')).ok() &&
                                                log->Append("c").ok();
                                       }),
            0);
  EXPECT_EQ(*ReadFile(path), std::string(60, 'a') + "\nc\n");
}

}  // namespace
}  // namespace egosieve::tools
