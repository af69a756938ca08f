#include "tools/cli/child_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "tests/testing/status.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

const auto kGoOn = [] { return false; };

TEST(RunChild, GivesExitCodeOutputsAndEnvironment) {
  ChildCommand command;
  command.arguments = {"/bin/sh", "-c", "echo to out $GREETING; echo to err >&2; exit 7"};
  command.environment["GREETING"] = "hello";
  command.log_path = testing::TempDir() + "/child.log";
  const auto code = Value(RunChild(command, kGoOn));
  EXPECT_EQ(code, 7);
  EXPECT_EQ(*ReadFile(command.log_path), "to out hello\nto err\n");
}

TEST(RunChild, TellsSignalsAndProgramsThatAreNotThere) {
  ChildCommand command;
  command.arguments = {"/bin/sh", "-c", "kill -9 $$"};
  command.log_path = testing::TempDir() + "/child.log";
  EXPECT_EQ(*RunChild(command, kGoOn), 128 + 9);
  command.arguments = {"/no/such/program"};
  const auto missing = RunChild(command, kGoOn);
  EXPECT_EQ(missing.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(missing.status().message(), HasSubstr("/no/such/program"));
}

TEST(RunChild, AStopRequestInterruptsTheChild) {
  ChildCommand command;
  // An interruption at the terminal has reached the child by itself: the same signal again would
  // end the child before its frame is done.
  command.arguments = {"/bin/sh", "-c",
                       "trap 'exit 130' TERM; trap 'exit 1' INT; while :; do sleep 0.01; done"};
  command.log_path = testing::TempDir() + "/child.log";
  int asked = 0;
  // Only after some looks, so that the shell has set its traps.
  const auto code = RunChild(command, [&] { return ++asked > 10; });
  ASSERT_TRUE(code.ok());
  EXPECT_EQ(*code, 130);
}

// Otherwise it would go on writing where the next run begins.
TEST(RunChild, AKilledParentEndsTheChild) {
  const std::string pid_path = testing::TempDir() + "/pid";
  unlink(pid_path.c_str());
  ChildCommand command;
  command.arguments = {"/bin/sh", "-c",
                       absl::StrCat("echo $$ > ", pid_path, ".tmp; mv ", pid_path, ".tmp ",
                                    pid_path, "; exec sleep 100000")};
  command.log_path = testing::TempDir() + "/child.log";
  const pid_t parent = fork();
  if (parent == 0) {
    (void)RunChild(command, kGoOn);
    _exit(1);
  }
  // Within a minute.
  const auto wait_until = [](const auto& condition) {
    for (int i = 0; i < 60000 && !condition(); ++i) usleep(1000);
    return condition();
  };
  ASSERT_TRUE(wait_until([&] { return ReadFile(pid_path).ok(); }));
  const pid_t child = static_cast<pid_t>(std::stoi(*ReadFile(pid_path)));
  EXPECT_EQ(kill(child, 0), 0);
  kill(parent, SIGKILL);
  waitpid(parent, nullptr, 0);
  // Gone, or dead and waiting for its new parent to notice.
  EXPECT_TRUE(wait_until([&] {
    const auto stat = ReadFile(absl::StrCat("/proc/", child, "/stat"));
    return !stat.ok() || stat->find(") Z ") != std::string::npos;
  }));
  kill(child, SIGKILL);
}

}  // namespace
}  // namespace egosieve::tools
