#include "tools/suite/child_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  const auto code = RunChild(command, kGoOn);
  ASSERT_TRUE(code.ok()) << code.status();
  EXPECT_EQ(*code, 7);
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
  EXPECT_THAT(std::string(missing.status().message()), HasSubstr("/no/such/program"));
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

}  // namespace
}  // namespace egosieve::tools
