// Every call of the system may fail: whichever does, a command never says that all is well while
// something is missing, changes nothing outside its run folder, and once the fault is gone the same
// command (segment and batch with --resume) gives the bytes of an undisturbed run.
//
// A library that is loaded before the others (failing_system.cc) makes one call fail. A sample of
// the calls by default; all of them where EGOSIEVE_FAULTS=all (hours).
#include <signal.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "gtest/gtest.h"
#include "tests/tools/faults/fault_kinds.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tests/tools/testing/run_comparison.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kSample = 2;  // calls of each kind
constexpr double kHangsAfterSeconds = 120.0;

bool TryAll() {
  const char* wish = std::getenv("EGOSIEVE_FAULTS");
  return wish != nullptr && std::string(wish) == "all";
}

// The command under test on a world of its own: input, manifest, a file of somebody else, the run.
struct Case {
  std::string name;
  std::vector<std::string> before;     // makes the folder that the command finds; empty: none
  std::vector<std::string> arguments;  // of the command
  std::vector<std::string> again;      // the same with the fault gone
};

class Faults : public testing::TestWithParam<std::string> {
 protected:
  Faults()
      // As the system names open files.
      : base_(fs::weakly_canonical(testing::TempDir() + "/" + GetParam()).string()),
        world_(base_ + "/world"),
        run_(world_ + "/run"),
        counts_(base_ + "/counts") {
    fs::remove_all(base_);
    fs::create_directories(base_);
    WritePatchDrive(world_, SmallPatchDrive(5));
    std::ofstream(world_ + "/notes.txt") << "somebody else's";
    fs::create_directories(world_ + "/sparse");
    std::ofstream(world_ + "/sparse/cameras.txt") << "1 SIMPLE_PINHOLE 160 96 150 80 48\n";
    std::ofstream(world_ + "/sparse/images.txt") << "1 1 0 0 0 0 0 0 1 000003\n9 9 5\n";
    std::ofstream(world_ + "/sparse/points3D.txt") << "5 0 0 0 1 2 3 0 1 0\n";
    std::ofstream(world_ + "/drives.toml") << "[a]\npath = 'frames'\nout = 'run'\nbudget = 100\n"
                                           << "stride = 8\ncheckpoint_every = 2\nthen = []\n";
  }
  ~Faults() override { unsetenv("LD_PRELOAD"); }

  std::vector<std::string> Segment(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {
        "segment",    world_ + "/frames",     "--out=" + run_,  "--budget=100",
        "--stride=8", "--checkpoint_every=2", "--progress=none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  // What merge takes over: the drive's second piece.
  std::string Piece() const { return world_ + "/piece"; }
  void WritePiece() const {
    std::vector<std::string> arguments = Segment({"--from=2", "--out=" + Piece()});
    std::erase(arguments, "--out=" + run_);
    ASSERT_EQ(Run(arguments, FaultKind::kRead, -1), 0) << Said();
  }

  Case MakeCase() const {
    const std::string name = GetParam();
    if (name == "segment") return {name, {}, Segment({}), Segment({"--resume"})};
    if (name == "merge") {
      const std::vector<std::string> merge = {name, run_, Piece(), "--progress=none"};
      return {name, Segment({"--to=2"}), merge, merge};
    }
    if (name == "batch") {
      const std::vector<std::string> batch = {"batch", world_ + "/drives.toml"};
      return {name, {}, batch, batch};
    }
    if (name == "points") {
      // Masks are the pictures themselves, which are not 0.
      const std::vector<std::string> points = {name,
                                               world_ + "/sparse",
                                               "--overwrite",
                                               "--masks=" + world_ + "/frames",
                                               "--out=" + MasksFolder(),
                                               "--progress=none"};
      return {name, Segment({}), points, points};
    }
    std::vector<std::string> command = {name, run_, "--progress=none"};
    if (name == "masks") {
      command.insert(command.end(), {"--for=colmap", "--overwrite", "--out=" + MasksFolder()});
    }
    return {name, Segment({}), command, command};
  }

  // Every file outside the folders that commands write to, with its bytes.
  std::map<std::string, std::string> Outside() const {
    std::map<std::string, std::string> files = FilesIn(world_);
    std::erase_if(files, [&](const auto& file) {
      const std::string& path = file.first;
      return path.rfind(run_ + "/", 0) == 0 || path.rfind(world_ + "/egosieve_logs/", 0) == 0 ||
             path.rfind(MasksFolder() + "/", 0) == 0;
    });
    return files;
  }

  // Of the commands masks and points.
  std::string MasksFolder() const { return world_ + "/masks"; }

  static std::map<std::string, std::string> FilesIn(const std::string& folder) {
    std::map<std::string, std::string> files;
    if (!fs::exists(folder)) return files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) files[entry.path().string()] = *ReadFile(entry.path().string());
    }
    return files;
  }

  // With the call `number` of the kind failing; below 0: none. kHung where it does not end.
  int Run(const std::vector<std::string>& arguments, FaultKind kind, int64_t number) const {
    const std::array<int64_t, kFaultKinds> zeros = {};
    std::ofstream(counts_, std::ios::binary)
        .write(reinterpret_cast<const char*>(zeros.data()), sizeof(zeros));
    setenv("EGOSIEVE_FAULT_COUNTS", counts_.c_str(), 1);
    setenv("EGOSIEVE_FAULT_ROOT", world_.c_str(), 1);
    setenv("EGOSIEVE_FAULT_KIND", kFaultNames[static_cast<int>(kind)], 1);
    setenv("EGOSIEVE_FAULT_NUMBER", absl::StrCat(number).c_str(), 1);
    setenv("LD_PRELOAD", fs::absolute("tests/tools/faults/libfailing_system.so").c_str(), 1);
    const pid_t process = StartProgram(arguments, base_ + "/out.txt", base_ + "/err.txt");
    unsetenv("LD_PRELOAD");
    const int code = WaitForProgram(process, kHangsAfterSeconds);
    if (code == kHung) {
      kill(process, SIGKILL);
      WaitForProgram(process);
    }
    return code;
  }

  std::array<int64_t, kFaultKinds> Counts() const {
    std::array<int64_t, kFaultKinds> counts = {};
    std::ifstream(counts_, std::ios::binary)
        .read(reinterpret_cast<char*>(counts.data()), sizeof(counts));
    return counts;
  }

  std::string Said() const { return *ReadFile(base_ + "/err.txt"); }

  // The folder as the command finds it.
  void Restore(const Case& test) const {
    fs::remove_all(run_);
    fs::remove_all(world_ + "/egosieve_logs");
    fs::remove_all(MasksFolder());
    if (!test.before.empty()) fs::copy(base_ + "/before", run_, fs::copy_options::recursive);
  }

  std::string base_, world_, run_, counts_;
};

std::vector<int64_t> ChooseCalls(int64_t count, uint64_t seed) {
  std::vector<int64_t> calls;
  if (TryAll()) {
    for (int64_t call = 0; call < count; ++call) calls.push_back(call);
    return calls;
  }
  std::mt19937_64 random(seed);
  for (int i = 0; i < kSample && count > 0; ++i) {
    calls.push_back(static_cast<int64_t>(random() % static_cast<uint64_t>(count)));
  }
  return calls;
}

// The program's own: x264 writes a line of its own where it lacks memory.
int64_t CountOwnLines(const std::string& said) {
  int64_t lines = 0;
  for (const absl::string_view line : absl::StrSplit(said, '\n', absl::SkipEmpty())) {
    lines += !absl::StartsWith(line, "x264 [");
  }
  return lines;
}

TEST_P(Faults, NeitherLoseNorHideAnything) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer has its own allocation";
#endif
  const Case test = MakeCase();
  if (test.name == "merge") WritePiece();
  if (!test.before.empty()) {
    ASSERT_EQ(Run(test.before, FaultKind::kRead, -1), 0) << Said();
    fs::rename(run_, base_ + "/before");
  }
  Restore(test);
  ASSERT_EQ(Run(test.arguments, FaultKind::kRead, -1), 0) << Said();
  const std::array<int64_t, kFaultKinds> counts = Counts();
  const std::string whole = base_ + "/whole";
  const auto masks = FilesIn(MasksFolder());
  EXPECT_EQ(masks.size(), test.name == "masks" ? 5u : test.name == "points" ? 3u : 0u);
  fs::rename(run_, whole);
  Restore(test);
  const auto outside = Outside();

  for (int kind = 0; kind < kFaultKinds; ++kind) {
    std::map<int, int> codes;
    for (const int64_t call : ChooseCalls(counts[kind], static_cast<uint64_t>(kind))) {
      const std::string where =
          absl::StrCat(test.name, ", ", kFaultNames[kind], " number ", call, " of ", counts[kind]);
      Restore(test);
      const int code = Run(test.arguments, static_cast<FaultKind>(kind), call);
      ++codes[code];
      EXPECT_NE(code, kHung) << where;
      EXPECT_TRUE(Outside() == outside) << where;
      if (code == 0) {
        // A report says which of its pictures are missing, on the page and here.
        const bool is_told = test.name == "report" && CountLines(Said()) == 1;
        if (!is_told) {
          EXPECT_EQ(CompareRuns(whole, run_), "") << where << ", exit code 0";
        }
        EXPECT_TRUE(FilesIn(MasksFolder()) == masks) << where << ", exit code 0";
      } else if (code != kHung && test.name != "batch") {  // which tells of its drives, too
        EXPECT_EQ(CountOwnLines(Said()), 1) << where << ":\n" << Said();
        EXPECT_LT(code, 128) << where;
      }
      const std::string said = Said();
      EXPECT_EQ(Run(test.again, FaultKind::kRead, -1), 0) << where << "\n" << said << Said();
      EXPECT_EQ(CompareRuns(whole, run_), "") << where << ", resumed\n" << said;
      EXPECT_TRUE(FilesIn(MasksFolder()) == masks) << where << ", resumed";
    }
    std::string line =
        absl::StrFormat("%s, %s: %d calls", test.name, kFaultNames[kind], counts[kind]);
    for (const auto& [code, times] : codes) {
      absl::StrAppend(&line, "; exit code ", code, ": ", times);
    }
    std::cout << line << std::endl;
  }
}

INSTANTIATE_TEST_SUITE_P(Commands, Faults,
                         testing::Values("segment", "refine", "masks", "render", "report", "batch",
                                         "merge", "points"),
                         [](const auto& command) { return command.param; });

}  // namespace
}  // namespace egosieve::tools
