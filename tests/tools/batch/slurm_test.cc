// The scripts that are written for Slurm, run as it would run them. sbatch, squeue, scancel and
// scontrol are stand-ins that write down what they are asked; tests/slurm/demo has the real ones.
#include "tools/batch/slurm.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fresh_folder.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class Slurm : public testing::Test {
 protected:
  Slurm() : root_(FreshFolder()), before_(std::getenv("PATH")) {
    options_.program = root_ + "/bin/it's egosieve";
    options_.folder = root_ + "/jobs";
    fs::create_directories(root_ + "/bin");
    StandIn("sbatch",
            "echo \"$@\" >>" + root_ + "/sbatch; echo a warning >&2; wc -l <" + root_ + "/sbatch");
    StandIn("squeue", "cat " + root_ + "/queued 2>/dev/null; true");
    StandIn("scontrol", "echo $* >>" + root_ + "/requeued");
    setenv("PATH", (root_ + "/bin:" + before_).c_str(), 1);
    cost_.seconds_per_frame = {{"segment", 0.5}, {"reconstruct", 0.1}, {"report", 0.001}};
    cost_.peak_memory_bytes = int64_t{600} << 20;
    cost_.measured_frames = 40;
    cost_.longest_drive_frames = 36000;
  }
  ~Slurm() override { setenv("PATH", before_.c_str(), 1); }

  void StandIn(const std::string& name, const std::string& text) const {
    const std::string path = root_ + "/bin/" + name;
    ASSERT_TRUE(WriteFileAtomically(path, "#!/bin/bash\n" + text + "\n").ok());
    fs::permissions(path, fs::perms::owner_all);
  }

  static BatchPlan Plan(size_t drives) {
    std::vector<BatchEntry> entries;
    for (size_t i = 0; i < drives; ++i) {
      entries.push_back({absl::StrCat("/in/", i), absl::StrCat("/nowhere/", i), {}});
    }
    return BatchPlan(entries, 0);
  }

  // The script's process, as element `element` of an array; its program is the stand-in.
  pid_t Start(const std::string& script, const std::string& element) const {
    EXPECT_TRUE(WriteFileAtomically(root_ + "/script.sh", script).ok());
    const pid_t process = fork();
    if (process == 0) {
      setenv("SLURM_ARRAY_JOB_ID", "7", 1);
      setenv("SLURM_ARRAY_TASK_ID", element.c_str(), 1);
      execl("/bin/bash", "bash", (root_ + "/script.sh").c_str(), nullptr);
      _exit(127);
    }
    return process;
  }

  static int Wait(pid_t process) {
    int status = 0;
    waitpid(process, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  void WaitForFile(const std::string& path) const {
    for (int i = 0; i < 60000 && !fs::exists(path); ++i) usleep(1000);
  }

  std::string root_, before_;
  SlurmOptions options_;
  BatchCost cost_;
};

TEST_F(Slurm, AsksForWhatWasMeasured) {
  const BatchPlan plan = Plan(1);
  // 36000 frames of 0.5 s, twice: 10 h.
  EXPECT_EQ(RequestFor(plan, 0, cost_, options_).minutes, 600 + 5);
  EXPECT_EQ(RequestFor(plan, 1, cost_, options_).minutes, 120 + 5);
  EXPECT_EQ(RequestFor(plan, 0, cost_, options_).memory_mebibytes, 1024);
}

TEST_F(Slurm, PiecesAskForTheLongestOfThemAndKeepTheirCuts) {
  const BatchPlan plan({{"/in/0", "/nowhere/0", {}, {}, {12000, 24000}}}, 0);
  // 12010 frames of 0.5 s, twice: 200.2 min.
  EXPECT_EQ(RequestFor(plan, 2, cost_, options_).minutes, 201 + 5);
  EXPECT_EQ(RequestFor(plan, 3, cost_, options_).minutes, 5) << "merge, which is not measured";
  ASSERT_TRUE(SubmitToSlurm(plan, {0}, cost_, options_).ok());
  EXPECT_THAT(*ReadFile(root_ + "/sbatch"), HasSubstr("aftercorr:1:2:3"));
  const auto entries = ReadManifest(options_.folder + "/drives.json");
  ASSERT_TRUE(entries.ok()) << entries.status();
  EXPECT_EQ((*entries)[0].cuts, plan.entries()[0].cuts);
}

TEST_F(Slurm, ArraysDependOnWhatTheirTasksNeed) {
  const BatchPlan plan = Plan(3);
  const absl::StatusOr<std::vector<SlurmArray>> arrays =
      SubmitToSlurm(plan, {0, 1, 2}, cost_, options_);
  ASSERT_TRUE(arrays.ok()) << arrays.status();
  ASSERT_THAT(*arrays, SizeIs(3));
  const std::string kill = " --kill-on-invalid-dep=yes ", jobs = options_.folder + "/";
  EXPECT_EQ(*ReadFile(root_ + "/sbatch"),
            "--parsable " + jobs + "segment.sh\n" +  //
                "--parsable --dependency=aftercorr:1" + kill + jobs + "reconstruct.sh\n" +
                "--parsable --dependency=aftercorr:2" + kill + jobs + "report.sh\n");
  EXPECT_EQ(SubmittedJobs(options_.folder), "1,2,3");
  EXPECT_THAT(*ReadFile(jobs + "segment.sh"), HasSubstr("#SBATCH --array=0-2\n"));
  const absl::StatusOr<std::vector<BatchEntry>> entries = ReadManifest(jobs + "drives.json");
  ASSERT_TRUE(entries.ok()) << entries.status();
  EXPECT_EQ((*entries)[1].out, "/nowhere/1");
}

TEST_F(Slurm, TheBatchAsItWasSubmittedHasWhatFollows) {
  const std::vector<BatchStep> then = {{"reconstruct", {}}, {"masks", {"--for=coco", "--invert"}}};
  const BatchPlan plan({{"/in/0", "/nowhere/0", {"--stride=2"}, then}}, 0);
  ASSERT_TRUE(SubmitToSlurm(plan, {0}, cost_, options_).ok());
  const auto entries = ReadManifest(options_.folder + "/drives.json");
  ASSERT_TRUE(entries.ok()) << entries.status();
  const BatchPlan read(*entries, 0);
  ASSERT_EQ(read.stages().size(), plan.stages().size());
  for (size_t stage = 0; stage < plan.stages().size(); ++stage) {
    EXPECT_EQ(read.Arguments(stage, 0), plan.Arguments(stage, 0));
  }
}

TEST_F(Slurm, MoreDrivesThanAnArrayHoldsAreSeveralArrays) {
  options_.largest_array = 4;
  options_.sbatch = {"--partition=long"};
  const BatchPlan plan = Plan(10);
  const absl::StatusOr<std::vector<SlurmArray>> arrays =
      SubmitToSlurm(plan, {0, 1, 3, 5, 8, 9}, cost_, options_);
  ASSERT_TRUE(arrays.ok()) << arrays.status();
  ASSERT_THAT(*arrays, SizeIs(3 * 3));
  EXPECT_THAT(*ReadFile((*arrays)[0].script), HasSubstr("--array=0-1,3\n"));
  EXPECT_THAT(*ReadFile((*arrays)[3].script), HasSubstr("--array=1\n"));
  const std::string last = *ReadFile((*arrays)[6].script);
  EXPECT_THAT(last, HasSubstr("--array=0-1\n"));
  EXPECT_THAT(last, HasSubstr("#SBATCH \"--partition=long\"\n"));
  EXPECT_THAT(last, HasSubstr("--task=$((8 + SLURM_ARRAY_TASK_ID))"));
  EXPECT_THAT(*ReadFile((*arrays)[7].script), HasSubstr("--task=$((18 + SLURM_ARRAY_TASK_ID))"));
}

// As squeue shows them: the jobs of `folder` are told by their names.
std::string NamesOfJobs(const SlurmOptions& options, const std::string& script) {
  const std::string text = *ReadFile(options.folder + "/" + script);
  const size_t begin = text.find("--job-name=") + 11;
  return text.substr(begin, text.find('\n', begin) - begin);
}

TEST_F(Slurm, WhereItTakesNoMoreJobsTheEarlierAreCancelled) {
  options_.submit = false;
  ASSERT_TRUE(SubmitToSlurm(Plan(2), {0, 1}, cost_, options_).ok());
  options_.submit = true;
  const std::string segment = NamesOfJobs(options_, "segment.sh");
  // The second has been taken, though sbatch was ended before it could print its number.
  StandIn("sbatch", "echo x >>" + root_ + "/calls; n=$(wc -l <" + root_ +
                        "/calls); [ $n -lt 2 ] && echo $n || { echo no room >&2; exit 1; }");
  ASSERT_TRUE(
      WriteFileAtomically(root_ + "/queued", "1 " + segment + "\n7 egosieve-segment-other\n2 " +
                                                 NamesOfJobs(options_, "reconstruct.sh") + "\n")
          .ok());
  StandIn("scancel", "echo $* >>" + root_ + "/cancelled");
  const absl::Status status = SubmitToSlurm(Plan(2), {0, 1}, cost_, options_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("no room"));
  EXPECT_EQ(*ReadFile(root_ + "/cancelled"), "1 2\n");
}

TEST_F(Slurm, JobsThatCannotBeCancelledAreTold) {
  StandIn("sbatch", "[ -e " + root_ + "/once ] && exit 1; touch " + root_ + "/once; echo 1");
  StandIn("squeue", "echo no answer >&2; exit 1");
  const absl::Status status = SubmitToSlurm(Plan(2), {0, 1}, cost_, options_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("may be left, cancel them: squeue ended"));
  EXPECT_EQ(SubmittedJobs(options_.folder), "1");
}

TEST_F(Slurm, WhatIsQueuedIsNotSubmittedAgain) {
  EXPECT_TRUE(CheckNothingIsQueued(options_.folder).ok());
  ASSERT_TRUE(SubmitToSlurm(Plan(1), {0}, cost_, options_).ok());
  EXPECT_TRUE(CheckNothingIsQueued(options_.folder).ok());
  // Also where the submission was killed before it could note anything, and in arrays.
  fs::remove(options_.folder + "/jobs.json");
  const std::string mine = NamesOfJobs(options_, "report.sh");
  ASSERT_TRUE(WriteFileAtomically(root_ + "/queued",
                                  "2 another\n3 " + mine + "\n3 " + mine + "\n4 " + mine + "\n")
                  .ok());
  const absl::Status status = CheckNothingIsQueued(options_.folder);
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(absl::EndsWith(status.message(), "scancel 3 4")) << status;
  EXPECT_TRUE(CheckNothingIsQueued(options_.folder + "_other").ok());
}

TEST_F(Slurm, AQueueThatIsNotToldIsNoEmptyOne) {
  StandIn("squeue", "echo no answer >&2; exit 1");
  const absl::Status status = CheckNothingIsQueued(options_.folder);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("no answer"));
}

TEST_F(Slurm, OptionsAndPathsAreQuotedOrRefused) {
  options_.folder = root_ + "/100% \"jobs\" #1";
  options_.sbatch = {"--comment=\"a#b\""};
  const std::string script =
      SlurmScript(Plan(1), 0, {0}, RequestFor(Plan(1), 0, cost_, options_), options_);
  EXPECT_THAT(script, HasSubstr("#SBATCH \"--output=" + root_ +
                                "/100%% \\\"jobs\\\" #1/segment.%a.log\"\n"));
  EXPECT_THAT(script, HasSubstr("#SBATCH \"--comment=\\\"a#b\\\"\"\n"));
  EXPECT_TRUE(options_.Validate().ok());
  for (const std::string option :
       {"long", "--comment=a\nb", "--job-name=x", "-Jx", "--array=1-9", "-o", "--output=y"}) {
    options_.sbatch = {option};
    EXPECT_EQ(options_.Validate().code(), absl::StatusCode::kInvalidArgument) << option;
  }
  options_.sbatch = {"--output-not-ours=1", "--account=x"};
  EXPECT_TRUE(options_.Validate().ok());
  for (const std::string folder : {"/a\nb", "/a\\b"}) {
    options_.folder = folder;
    EXPECT_EQ(options_.Validate().code(), absl::StatusCode::kInvalidArgument) << folder;
  }
}

TEST_F(Slurm, AScriptGivesItsTasksExitCode) {
  const std::string script =
      SlurmScript(Plan(3), 1, {0, 1, 2}, RequestFor(Plan(3), 1, cost_, options_), options_);
  for (const auto& [code, told] : std::vector<std::pair<int, int>>{{0, 0}, {4, 0}, {3, 3}}) {
    StandIn("it's egosieve", "echo \"$@\" >" + root_ + "/called; exit " + absl::StrCat(code));
    EXPECT_EQ(Wait(Start(script, "2")), told);
  }
  EXPECT_EQ(*ReadFile(root_ + "/called"), "batch " + options_.folder + "/drives.json --task=5\n");
  EXPECT_FALSE(fs::exists(root_ + "/requeued"));
}

TEST_F(Slurm, ATaskWhoseTimeIsOverDrainsAndIsQueuedAgain) {
  const std::string script =
      SlurmScript(Plan(3), 0, {0, 1, 2}, RequestFor(Plan(3), 0, cost_, options_), options_);
  StandIn("it's egosieve", "trap 'echo drained >" + root_ + "/drained; exit 130' TERM\ntouch " +
                               root_ + "/ready\nwhile :; do sleep 0.05; done");
  for (const int signal : {SIGUSR1, SIGTERM}) {
    fs::remove(root_ + "/ready");
    fs::remove(root_ + "/drained");
    fs::remove(root_ + "/requeued");
    const pid_t process = Start(script, "1");
    WaitForFile(root_ + "/ready");
    kill(process, signal);
    const int code = Wait(process);
    EXPECT_TRUE(fs::exists(root_ + "/drained"));
    // SIGTERM alone is scancel, or a preemption after which Slurm itself queues it again.
    EXPECT_EQ(code, signal == SIGUSR1 ? 0 : 130);
    EXPECT_EQ(ReadFile(root_ + "/requeued").value_or(""), signal == SIGUSR1 ? "requeue 7_1\n" : "");
  }
}

// The task has begun, and the shell may not know its number yet.
TEST_F(Slurm, ASignalAtATasksBeginningIsNotLost) {
  const std::string script =
      SlurmScript(Plan(3), 0, {0, 1, 2}, RequestFor(Plan(3), 0, cost_, options_), options_);
  StandIn("it's egosieve", "trap 'exit 130' TERM\nkill -USR1 $PPID\nwhile :; do sleep 0.05; done");
  for (int i = 0; i < 5; ++i) {
    fs::remove(root_ + "/requeued");
    EXPECT_EQ(Wait(Start(script, "1")), 0);
    EXPECT_EQ(ReadFile(root_ + "/requeued").value_or(""), "requeue 7_1\n");
  }
}

}  // namespace
}  // namespace egosieve::tools
