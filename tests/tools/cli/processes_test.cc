#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "tests/testing/status.h"
#include "tests/tools/testing/program.h"
#include "tools/cli/child_process.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

using ::testing::ContainsRegex;
using ::testing::EndsWith;
using ::testing::HasSubstr;

const auto kGoOn = [] { return false; };

TEST(RunChild, GivesExitCodeAndOutputs) {
  const std::string log = testing::TempDir() + "/child.log";
  const auto code =
      Value(RunChild({"/bin/sh", "-c", "echo to out; echo to err >&2; exit 7"}, log, kGoOn));
  EXPECT_EQ(code, 7);
  EXPECT_EQ(*ReadFile(log), "to out\nto err\n");
}

TEST(RunChild, TellsSignalsAndProgramsThatAreNotThere) {
  const std::string log = testing::TempDir() + "/child.log";
  EXPECT_EQ(*RunChild({"/bin/sh", "-c", "kill -9 $$"}, log, kGoOn), 128 + 9);
  const auto missing = RunChild({"/no/such/program"}, log, kGoOn);
  EXPECT_THAT(missing.status(), IsError(absl::StatusCode::kUnavailable, "/no/such/program"));
}

TEST(RunChild, AStopRequestInterruptsTheChild) {
  // An interruption at the terminal has reached the child by itself: the same signal again would
  // end the child before its frame is done.
  const std::string script =
      "trap 'exit 130' TERM; trap 'exit 1' INT; while :; do sleep 0.01; done";
  int asked = 0;
  // Only after some looks, so that the shell has set its traps.
  const auto code = RunChild({"/bin/sh", "-c", script}, testing::TempDir() + "/child.log",
                             [&] { return ++asked > 10; });
  ASSERT_TRUE(code.ok());
  EXPECT_EQ(*code, 130);
}

// Otherwise it would go on writing where the next run begins.
TEST(RunChild, AKilledParentEndsTheChild) {
  const std::string pid_path = testing::TempDir() + "/pid";
  unlink(pid_path.c_str());
  const std::string script = absl::StrCat("echo $$ > ", pid_path, ".tmp; mv ", pid_path, ".tmp ",
                                          pid_path, "; exec sleep 100000");
  const pid_t parent = fork();
  if (parent == 0) {
    (void)RunChild({"/bin/sh", "-c", script}, testing::TempDir() + "/child.log", kGoOn);
    _exit(1);
  }
  ASSERT_TRUE(WaitUntil([&] { return ReadFile(pid_path).ok(); }));
  const pid_t child = static_cast<pid_t>(std::stoi(*ReadFile(pid_path)));
  EXPECT_EQ(kill(child, 0), 0);
  kill(parent, SIGKILL);
  waitpid(parent, nullptr, 0);
  // Gone, or dead and waiting for its new parent to notice.
  EXPECT_TRUE(WaitUntil([&] {
    const auto stat = ReadFile(absl::StrCat("/proc/", child, "/stat"));
    return !stat.ok() || stat->find(") Z ") != std::string::npos;
  }));
  kill(child, SIGKILL);
}

TEST(Interruption, TheFirstIsARequestAndTheSecondEndsTheProcess) {
  for (const int signal : {SIGINT, SIGTERM}) {
    EXPECT_EXIT(
        {
          CatchInterruptions();
          raise(signal);
          if (!InterruptionRequested()) _exit(1);
          raise(signal);
          _exit(2);
        },
        testing::KilledBySignal(signal), "");
  }
}

TEST(Interruption, OneOfEachKindIsARequest) {
  EXPECT_EXIT(
      {
        CatchInterruptions();
        raise(SIGINT);
        raise(SIGTERM);
        _exit(InterruptionRequested() ? 7 : 1);
      },
      testing::ExitedWithCode(7), "");
}

TEST(Interruption, ThoseHeldBackAreCaughtLater) {
  EXPECT_EXIT(
      {
        HoldInterruptions();
        raise(SIGINT);
        if (InterruptionRequested()) _exit(1);
        CatchInterruptions();
        _exit(InterruptionRequested() ? 7 : 2);
      },
      testing::ExitedWithCode(7), "");
}

TEST(Progress, JsonIsAnObjectForEveryFrame) {
  std::ostringstream stream;
  {
    Progress progress("segment", ProgressMode::kJson, 3, stream, true);
    progress.Advance({{"model size", 12.0}});
    progress.Advance({{"model size", 13.0}});
  }
  std::istringstream lines(stream.str());
  std::string line;
  int64_t done = 0;
  while (std::getline(lines, line)) {
    const auto json = nlohmann::json::parse(line);
    EXPECT_EQ(json["command"], "segment");
    EXPECT_EQ(json["done"], ++done);
    EXPECT_EQ(json["total"], 3);
    EXPECT_EQ(json["model_size"], 11.0 + static_cast<double>(done));
    EXPECT_EQ(json["frames_per_second"], 0.0);  // two in no time are no rate
    EXPECT_EQ(json["eta_seconds"], -1.0);
  }
  EXPECT_EQ(done, 2);
}

TEST(Progress, ATerminalHasABarThatEndsWithALineBreak) {
  std::ostringstream stream;
  Progress progress("segment", ProgressMode::kAuto, 8, stream, true);
  for (int i = 0; i < 8; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(210));
    EXPECT_TRUE(progress.AdvanceUninterrupted());
  }
  progress.Finish();
  progress.Finish();
  EXPECT_THAT(stream.str(), HasSubstr("[###.....................] segment: 1/8 frames\r"));
  EXPECT_THAT(stream.str(),
              ContainsRegex("#\\.+\\] segment: 5/8 frames, 4\\.[0-9] frames/s, 1 s to go\r"));
  EXPECT_THAT(stream.str(),
              ContainsRegex("#\\] segment: 8/8 frames in 2 s, 4\\.[0-9] frames/s\n$"));
  EXPECT_THAT(stream.str(), EndsWith("\n"));
  EXPECT_THAT(stream.str(), testing::Not(EndsWith("\n\n")));
}

TEST(Progress, IsSilentWhereItShouldBe) {
  std::ostringstream none, quick;
  Progress silent("segment", ProgressMode::kNone, 4, none, true);
  silent.Advance();
  silent.Finish();
  EXPECT_EQ(none.str(), "");
  Progress line("segment", ProgressMode::kAuto, 4, quick, false);  // done before a line is due
  line.Advance();
  line.Finish();
  EXPECT_EQ(quick.str(), "");
}

TEST(Progress, SaysLinesBesideTheBarToPeopleAlone) {
  std::ostringstream bar, lines, json;
  Progress("run", ProgressMode::kAuto, 4, bar, true).Say("look");
  Progress("run", ProgressMode::kAuto, 4, lines, false).Say("look");
  Progress("run", ProgressMode::kJson, 4, json, true).Say("look");
  EXPECT_EQ(bar.str(), "\r\033[2Krun: look\n");
  EXPECT_EQ(lines.str(), "run: look\n");
  EXPECT_EQ(json.str(), "");
}

TEST(Progress, DoesNotTrustTheTotal) {
  std::ostringstream stream;
  Progress progress("segment", ProgressMode::kJson, 1, stream, false);
  progress.Advance();
  progress.Advance();
  EXPECT_THAT(stream.str(), HasSubstr("\"done\":2,\"total\":1"));
  EXPECT_THAT(stream.str(), HasSubstr("\"eta_seconds\":0"));
}

TEST(Progress, CountsInItsUnit) {
  std::ostringstream stream;
  {
    Progress progress("evaluate", ProgressMode::kAuto, 2, stream, true, "sequence");
    std::this_thread::sleep_for(std::chrono::milliseconds(110));
    progress.Advance();
  }
  EXPECT_THAT(stream.str(), HasSubstr("evaluate: 1/2 sequences in 0 s, "));
  EXPECT_THAT(stream.str(), HasSubstr(" sequences/s\n"));
}

TEST(MovingRate, IsNotThatOfTheFirstNorOfABurst) {
  MovingRate rate;
  EXPECT_EQ(rate.PerSecond(), 0.0);
  rate.Add(6.5, 1);
  EXPECT_EQ(rate.PerSecond(), 0.0);
  for (int i = 2; i <= 13; ++i) rate.Add(6.5 + 1e-6 * i, i);
  EXPECT_NEAR(rate.PerSecond(), 2.0, 1e-3);
  MovingRate burst;
  for (int i = 1; i <= 13; ++i) burst.Add(1e-6 * i, i);
  EXPECT_EQ(burst.PerSecond(), 0.0);
}

TEST(MovingRate, FollowsWhatSlowsDown) {
  MovingRate rate;
  int64_t done = 0;
  double seconds = 0.0;
  for (; seconds < 90.0; seconds += 0.01) rate.Add(seconds, ++done);
  EXPECT_NEAR(rate.PerSecond(), 100.0, 0.5);
  for (; seconds < 160.0; seconds += 0.5) rate.Add(seconds, ++done);
  EXPECT_NEAR(rate.PerSecond(), 2.0, 0.05);
}

TEST(DescribeDuration, ReadsWell) {
  EXPECT_EQ(DescribeDuration(0.2), "0 s");
  EXPECT_EQ(DescribeDuration(59.4), "59 s");
  EXPECT_EQ(DescribeDuration(185.0), "3 min 05 s");
  EXPECT_EQ(DescribeDuration(2 * 3600.0 + 7 * 60.0), "2 h 07 min");
}

}  // namespace
}  // namespace egosieve::tools
