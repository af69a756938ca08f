// Commands of one drive, killed at random moments over and over, until the time is up; every drive
// that comes through must have the bytes of one that nobody disturbed.
//
//   kill_soak --seconds=3600 --seed=1
//
// A line a drive; the last line counts: drives, kills, differences. Exit code 1 where there were
// any.
#include <signal.h>
#include <stdlib.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tests/tools/testing/run_comparison.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr int kFrames = 14;
constexpr double kHangsAfterSeconds = 300.0;

class Soak {
 public:
  Soak(std::string folder, uint64_t seed) : folder_(std::move(folder)), random_(seed) {
    WritePatchDrive(folder_, SmallPatchDrive(kFrames));
  }

  // What is run on one drive, in this order. The first goes on where it was killed, the others
  // start again.
  std::vector<std::vector<std::string>> Commands(const std::string& run) const {
    return {{"segment", folder_ + "/frames", "--out=" + run, "--resume", "--budget=150",
             "--stride=8", "--checkpoint_every=4", "--progress=none"},
            {"refine", run, "--progress=none"},
            {"render", run, "--progress=none", "--images", "--no_video"}};
  }

  bool Begin() {
    for (const auto& command : Commands(folder_ + "/whole")) {
      const auto start = Clock::now();
      if (const int code = WaitForProgram(Start(command), kHangsAfterSeconds); code != 0) {
        std::cout << command[0] << " ended with " << code << " without a kill\n";
        return false;
      }
      durations_.push_back(Seconds(Clock::now() - start).count());
    }
    return true;
  }

  // One drive from its first command to its last. Returns what is wrong with it, "" for nothing.
  std::string Drive(bool* out_of_time, Clock::time_point end) {
    const std::string run = folder_ + "/run";
    fs::remove_all(run);
    const auto commands = Commands(run);
    for (size_t i = 0; i < commands.size(); ++i) {
      while (true) {
        *out_of_time = Clock::now() > end;
        if (*out_of_time) return "";
        const pid_t process = Start(commands[i]);
        // Every second attempt may come through, so that a drive ends at some time.
        const double share = static_cast<double>(random_() % 1000) / 500.0;
        int code = WaitForProgram(process, durations_[i] * share);
        if (code == kHung) {
          const int signal = random_() % 4 == 0 ? SIGTERM : SIGKILL;
          kill(process, signal);
          ++kills_;
          code = WaitForProgram(process, kHangsAfterSeconds);
          if (code == kHung) {
            kill(process, SIGKILL);
            WaitForProgram(process, kHangsAfterSeconds);
            return absl::StrCat(commands[i][0], " did not end within ", kHangsAfterSeconds,
                                " s of SIGTERM");
          }
        }
        if (code == 0) break;
        if (code != 128 + SIGKILL && code != 128 + SIGTERM && code != 130) {
          return absl::StrCat(commands[i][0], " ended with ", code);
        }
      }
    }
    return CompareRuns(folder_ + "/whole", run);
  }

  int64_t kills() const { return kills_; }

 private:
  pid_t Start(const std::vector<std::string>& arguments) const {
    return StartProgram(arguments, folder_ + "/out.txt", folder_ + "/err.txt");
  }

  std::string folder_;
  std::mt19937_64 random_;
  std::vector<double> durations_;  // seconds of each command, undisturbed
  int64_t kills_ = 0;
};

int Run(double seconds, uint64_t seed) {
  std::string folder = (fs::temp_directory_path() / "egosieve-soak-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) return 1;
  Soak soak(folder, seed);
  if (!soak.Begin()) return 1;
  const auto start = Clock::now();
  const auto end = start + std::chrono::duration_cast<Clock::duration>(Seconds(seconds));
  int64_t drives = 0, differences = 0;
  bool out_of_time = false;
  while (true) {
    const std::string difference = soak.Drive(&out_of_time, end);
    if (out_of_time) break;
    ++drives;
    if (!difference.empty()) ++differences;
    std::cout << absl::StrFormat("drive %d, %d kills so far: %s", drives, soak.kills(),
                                 difference.empty() ? "the same bytes" : difference)
              << std::endl;
    if (!difference.empty()) {
      fs::rename(folder + "/run", absl::StrCat(folder, "/different-", differences));
    }
  }
  if (differences == 0) fs::remove_all(folder);
  std::cout << absl::StrFormat("soak: %.0f s, %d drives, %d kills, %d differences%s\n", seconds,
                               drives, soak.kills(), differences,
                               differences == 0 ? "" : ", kept in " + folder);
  return differences == 0 ? 0 : 1;
}

}  // namespace
}  // namespace egosieve::tools

int main(int argc, char** argv) {
  CLI::App app("Kills commands at random moments; see the head of the source");
  double seconds = 3600.0;
  uint64_t seed = 1;
  app.add_option("--seconds", seconds, "How long");
  app.add_option("--seed", seed, "Of the moments");
  CLI11_PARSE(app, argc, argv);
  return egosieve::tools::Run(seconds, seed);
}
