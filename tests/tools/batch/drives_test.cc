#include "tools/batch/drives.h"

#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tests/tools/testing/program.h"
#include "tools/batch/slurm.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::MatchesRegex;
using ::testing::SizeIs;
namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(ParseManifest, DefaultsAreSharedAndADriveGoesBeforeThem) {
  const auto entries = Value(ParseManifest(R"([defaults]
out = "runs"
then = ["refine", "masks"]
profile = "fast"
deterministic = true
masks.for = "colmap"

[a]  # the first
path = "a.mp4"

[b]
path = '/b # c.mp4'
out = "elsewhere/b/"
profile = "paper"
deterministic = false
stride = 0.5
then = "report"
)",
                                           "/drives"));
  ASSERT_EQ(entries.size(), 2u);
  const BatchDrive& a = entries[0];
  EXPECT_EQ(a.path, "/drives/a.mp4");
  EXPECT_EQ(a.out, "/drives/runs/a");
  EXPECT_THAT(a.flags.at("segment"), ElementsAre("--profile=fast", "--deterministic"));
  EXPECT_THAT(a.flags.at("masks"), ElementsAre("--for=colmap"));
  EXPECT_THAT(a.then, ElementsAre("refine", "masks"));
  const BatchDrive& b = entries[1];
  EXPECT_EQ(b.path, "/b # c.mp4");
  EXPECT_EQ(b.out, "/drives/elsewhere/b");
  EXPECT_THAT(b.flags.at("segment"),
              ElementsAre("--profile=paper", "--deterministic=false", "--stride=0.5"));
  EXPECT_THAT(b.then, ElementsAre("report"));
}

TEST(ParseManifest, RefineAndReportFollowWhereNothingIsSaid) {
  const auto entries = Value(ParseManifest("[a]\npath = 'a'\nout = 'a'\n", ""));
  EXPECT_THAT(entries[0].then, ElementsAre("refine", "report"));
}

TEST(ParseManifest, KnowsReconstructAsRefine) {
  const auto entries = Value(ParseManifest(
      "[a]\npath = 'a'\nout = 'a'\nthen = 'reconstruct'\nreconstruct.causal = true\n", ""));
  EXPECT_THAT(entries[0].then, ElementsAre("refine"));
  EXPECT_THAT(entries[0].flags.at("refine"), ElementsAre("--causal"));
}

TEST(ParseManifest, WhatIsGivenGoesBeforeAll) {
  BatchSettings given;
  given.out = "/given";
  given.then = "report";
  given.segment_flags = "--profile=default --set=model=exact";
  const auto entries = Value(
      ParseManifest("[defaults]\nout = \"runs\"\n[a]\npath = \"a\"\nprofile = \"fast\"\nthen = "
                    "\"render\"\n[b]\npath = \"b\"\nout = \"own\"\n",
                    "/drives", given));
  EXPECT_EQ(entries[0].out, "/given/a");
  EXPECT_EQ(entries[1].out, "/drives/own");
  EXPECT_THAT(entries[0].flags.at("segment"),
              ElementsAre("--profile=default", "--set=model=exact"));
  EXPECT_THAT(entries[0].then, ElementsAre("report"));
}

TEST(ParseManifest, GivesCutsAndResearchSettings) {
  const auto entries =
      Value(ParseManifest("[a]\npath = 'a.mp4'\nout = 'a'\ncuts = [100, 250]\nstride = 2\n"
                          "[a.research]\nmodel = 'exact'\nwindow = 5\n",
                          "/drives"));
  EXPECT_THAT(entries.front().cuts, ElementsAre(100, 250));
  EXPECT_THAT(entries.front().flags.at("segment"),
              ElementsAre("--stride=2", "--set=model=exact", "--set=window=5"));
}

TEST(ParseManifest, WhatIsWrongIsSaidWithItsLine) {
  const auto error = [](const std::string& text) {
    const auto entries = ParseManifest(text, "");
    EXPECT_THAT(entries, IsInvalid()) << text;
    return std::string(entries.status().message());
  };
  const std::string whole = "[a]\npath = 'a'\nout = 'x'\n";
  EXPECT_THAT(error(""), HasSubstr("lists no drive"));
  EXPECT_THAT(error("[defaults]\nstride = 2\n"), HasSubstr("lists no drive"));
  EXPECT_THAT(error("[a]\npath = a.mp4\n"), StartsWith("line 2"));
  EXPECT_THAT(error("[:]\n"), StartsWith("line 1"));
  EXPECT_THAT(error("[a]\npath = \"a\"\npath = \"b\"\n"), StartsWith("line 3"));
  EXPECT_THAT(error("path = 'a'\n"), StartsWith("line 1: path: outside the tables"));
  EXPECT_THAT(error("[a]\npath = 'a'\n"), StartsWith("a: no 'out'"));
  EXPECT_THAT(error("[a]\nout = 'a'\n"), StartsWith("a: no 'path'"));
  for (const char* cuts : {"[5, 5]", "[0]", "['a']", "[1.5]", "-3"}) {
    EXPECT_THAT(error(whole + "cuts = " + cuts), HasSubstr("'cuts' is not an ascending")) << cuts;
  }
  EXPECT_THAT(error(whole + "stride = [1, 2]\n"),
              HasSubstr("line 4: a: 'stride' has no single value"));
  EXPECT_THAT(error(whole + "masks.for.us = 1\n"), HasSubstr("'us' has no single value"));
  EXPECT_THAT(error(whole + "then = 'sing'\n"), HasSubstr("'sing' is none of refine"));
  EXPECT_THAT(error(whole + "sing.loud = true\n"), HasSubstr("'sing' is none of refine"));
}

TEST(DriveCuts, AreTheFewestPiecesOfEqualLength) {
  EXPECT_THAT(EqualCuts(3000, 0.1, 5), ElementsAre());
  EXPECT_THAT(EqualCuts(3001, 0.1, 5), ElementsAre(1500));
  EXPECT_THAT(EqualCuts(9001, 0.1, 5), ElementsAre(2250, 4500, 6750));
  EXPECT_THAT(EqualCuts(3, 1.0, 1e-9), ElementsAre(1, 2)) << "no piece is empty";
  EXPECT_THAT(EqualCuts(-1, 0.1, 5), ElementsAre()) << "a length that no header tells";
}

// The scripts that are written for Slurm, run as it would run them. sbatch, squeue, scancel and
// scontrol are stand-ins that write down what they are asked; tests/slurm/demo has the real ones.

class Slurm : public testing::Test {
 protected:
  Slurm() : root_(FreshFolder()), before_(std::getenv("PATH")) {
    options_.program = root_ + "/bin/it's egosieve";
    options_.folder = root_ + "/jobs";
    fs::create_directories(root_ + "/bin");
    StandIn("sbatch", "printf '[%s]' \"$@\" >>" + root_ + "/sbatch; echo >>" + root_ +
                          "/sbatch; echo a warning >&2; wc -l <" + root_ + "/sbatch");
    StandIn("squeue", "cat " + root_ + "/queued 2>/dev/null; true");
    StandIn("scontrol", "echo $* >>" + root_ + "/requeued");
    setenv("PATH", (root_ + "/bin:" + before_).c_str(), 1);
  }
  ~Slurm() override { setenv("PATH", before_.c_str(), 1); }

  void StandIn(const std::string& name, const std::string& text) const {
    const std::string path = root_ + "/bin/" + name;
    ASSERT_TRUE(WriteFileAtomically(path, "#!/bin/bash\n" + text + "\n").ok());
    fs::permissions(path, fs::perms::owner_all);
  }

  static BatchPlan Plan(size_t drives) {
    std::vector<BatchDrive> all;
    for (size_t i = 0; i < drives; ++i) {
      all.push_back({absl::StrCat("/in/", i), absl::StrCat("/nowhere/", i)});
    }
    return *BatchPlan::Create(all);
  }

  // The process of the script that jobs run, as element `element` of the array of a stage whose
  // first task is `first`; its program is the stand-in.
  pid_t Start(const std::string& first, const std::string& element) const {
    EXPECT_TRUE(SubmitToSlurm(Plan(1), {0}, options_).ok());
    const pid_t process = fork();
    if (process == 0) {
      setenv("SLURM_ARRAY_JOB_ID", "7", 1);
      setenv("SLURM_ARRAY_TASK_ID", element.c_str(), 1);
      execl("/bin/bash", "bash", (options_.folder + "/task.sh").c_str(), options_.program.c_str(),
            (options_.folder + "/submitted.json").c_str(), first.c_str(), nullptr);
      _exit(127);
    }
    return process;
  }

  std::string root_, before_;
  SlurmOptions options_;
};

TEST_F(Slurm, ArraysDependOnWhatTheirTasksNeed) {
  options_.sbatch = {"--partition=long", "--comment=\"a#b\""};
  const std::vector<SlurmArray> arrays = Value(SubmitToSlurm(Plan(3), {0, 1, 2}, options_));
  ASSERT_THAT(arrays, SizeIs(3));
  EXPECT_EQ(arrays[2].job, "3");
  const std::vector<std::string> lines = absl::StrSplit(*ReadFile(root_ + "/sbatch"), '\n');
  const std::string jobs = options_.folder, kill = "[--kill-on-invalid-dep=yes]";
  const auto call = [&](const std::string& first) {
    return absl::StrCat("[", jobs, "/task.sh][", options_.program, "][", jobs, "/submitted.json][",
                        first, "]");
  };
  // Of what is given twice sbatch takes the last: the user's options go before the batch's own.
  EXPECT_THAT(lines[0], MatchesRegex("\\[--parsable\\]\\[--requeue\\].*\\[--partition=long\\]"
                                     "\\[--comment=\"a#b\"\\]"
                                     "\\[--job-name=egosieve-segment-[0-9a-f]+\\]"
                                     "\\[--array=0-2\\].*"));
  EXPECT_THAT(lines[0], HasSubstr("[--output=" + jobs + "/segment.%a.log]" + call("0")));
  EXPECT_THAT(lines[1], HasSubstr("[--dependency=aftercorr:1]" + kill + call("3")));
  EXPECT_THAT(lines[2], HasSubstr("[--dependency=aftercorr:2]" + kill + call("6")));
  const auto plan = Value(BatchPlan::FromText(*ReadFile(jobs + "/submitted.json")));
  EXPECT_EQ(plan.drives()[1].out, "/nowhere/1");
}

TEST_F(Slurm, WhatFollowsPiecesDependsOnAllOfThem) {
  ASSERT_TRUE(SubmitToSlurm(*BatchPlan::Create({{"/in/0", "/nowhere/0", {}, {}, {120, 240}}}), {0},
                            options_)
                  .ok());
  EXPECT_THAT(*ReadFile(root_ + "/sbatch"), HasSubstr("aftercorr:1:2:3"));
}

TEST_F(Slurm, MoreDrivesThanAnArrayHoldsAreSeveralArrays) {
  options_.largest_array = 4;
  const auto arrays = Value(SubmitToSlurm(Plan(10), {0, 1, 3, 5, 8, 9}, options_));
  ASSERT_THAT(arrays, SizeIs(3 * 3));
  const std::vector<std::string> lines = absl::StrSplit(*ReadFile(root_ + "/sbatch"), '\n');
  EXPECT_THAT(lines[0], HasSubstr("[--array=0-1,3]"));
  EXPECT_THAT(lines[3], HasSubstr("[--array=1]"));
  EXPECT_THAT(lines[6], AllOf(HasSubstr("[--array=0-1]"), HasSubstr("/segment_from_8.%a.log]"),
                              EndsWith("[8]")));
  EXPECT_THAT(lines[7], EndsWith("[18]"));
}

// As squeue shows them: the jobs of a folder are told by their names.
std::string NameOfJob(const std::string& sbatch, size_t number) {
  const std::vector<std::string> calls = absl::StrSplit(sbatch, '\n');
  const size_t begin = calls[number].find("--job-name=") + 11;
  return calls[number].substr(begin, calls[number].find(']', begin) - begin);
}

TEST_F(Slurm, WhereItTakesNoMoreJobsTheEarlierGoOn) {
  StandIn("sbatch", "[ -e " + root_ + "/once ] && echo no room >&2 && exit 1; touch " + root_ +
                        "/once; echo 1");
  const absl::Status status = SubmitToSlurm(Plan(2), {0, 1}, options_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(status.message(), AllOf(HasSubstr("no room"), HasSubstr("submitted before go on")));
}

TEST_F(Slurm, WhatIsQueuedIsNotSubmittedAgain) {
  ASSERT_TRUE(SubmitToSlurm(Plan(1), {0}, options_).ok());
  // Also where the submission was killed: Slurm tells of them. In arrays, several lines.
  const std::string mine = NameOfJob(*ReadFile(root_ + "/sbatch"), 2);
  ASSERT_TRUE(WriteFileAtomically(root_ + "/queued",
                                  "2 another\n3 " + mine + "\n3 " + mine + "\n4 " + mine + "\n")
                  .ok());
  const absl::Status status = SubmitToSlurm(Plan(1), {0}, options_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(absl::EndsWith(status.message(), "scancel 3 4")) << status;
  options_.folder += "_other";
  EXPECT_TRUE(SubmitToSlurm(Plan(1), {0}, options_).ok());
}

TEST_F(Slurm, AQueueThatIsNotToldIsNoEmptyOne) {
  StandIn("squeue", "echo no answer >&2; exit 1");
  EXPECT_THAT(SubmitToSlurm(Plan(1), {0}, options_),
              IsError(absl::StatusCode::kUnavailable, "no answer"));
}

TEST_F(Slurm, PathsAreAsTheyAre) {
  options_.folder = root_ + "/100% \"jobs\" #1";
  ASSERT_TRUE(SubmitToSlurm(Plan(1), {0}, options_).ok());
  EXPECT_THAT(*ReadFile(root_ + "/sbatch"),
              AllOf(HasSubstr("[--output=" + root_ + "/100%% \"jobs\" #1/segment.%a.log]"),
                    HasSubstr("[" + options_.folder + "/task.sh]")));
}

TEST_F(Slurm, AScriptGivesItsTasksExitCode) {
  for (const auto& [code, told] : std::vector<std::pair<int, int>>{{0, 0}, {4, 0}, {3, 3}}) {
    StandIn("it's egosieve", "echo \"$@\" >" + root_ + "/called; exit " + absl::StrCat(code));
    EXPECT_EQ(WaitForProgram(Start("3", "2")), told);
  }
  EXPECT_EQ(*ReadFile(root_ + "/called"),
            "batch " + options_.folder + "/submitted.json --task=5\n");
  EXPECT_FALSE(fs::exists(root_ + "/requeued"));
}

TEST_F(Slurm, ATaskWhoseTimeIsOverDrainsAndIsQueuedAgain) {
  StandIn("it's egosieve", "trap 'echo drained >" + root_ + "/drained; exit 130' TERM\ntouch " +
                               root_ + "/ready\nwhile :; do sleep 0.05; done");
  for (const int signal : {SIGUSR1, SIGTERM}) {
    fs::remove(root_ + "/ready");
    fs::remove(root_ + "/drained");
    fs::remove(root_ + "/requeued");
    const pid_t process = Start("0", "1");
    WaitUntil([&] { return fs::exists(root_ + "/ready"); });
    kill(process, signal);
    const int code = WaitForProgram(process);
    EXPECT_TRUE(fs::exists(root_ + "/drained"));
    // SIGTERM alone is scancel, or a preemption after which Slurm itself queues it again.
    EXPECT_EQ(code, signal == SIGUSR1 ? 0 : 130);
    EXPECT_EQ(ReadFile(root_ + "/requeued").value_or(""), signal == SIGUSR1 ? "requeue 7_1\n" : "");
  }
}

// The task has begun, and the shell may not know its number yet.
TEST_F(Slurm, ASignalAtATasksBeginningIsNotLost) {
  StandIn("it's egosieve", "trap 'exit 130' TERM\nkill -USR1 $PPID\nwhile :; do sleep 0.05; done");
  for (int i = 0; i < 5; ++i) {
    fs::remove(root_ + "/requeued");
    EXPECT_EQ(WaitForProgram(Start("0", "1")), 0);
    EXPECT_EQ(ReadFile(root_ + "/requeued").value_or(""), "requeue 7_1\n");
  }
}

}  // namespace
}  // namespace egosieve::tools
