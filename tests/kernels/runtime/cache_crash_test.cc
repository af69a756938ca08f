// The program cache on a machine where processes run side by side and die at any moment: a binary
// that is loaded is one that was stored, whole. Nothing here depends on how long anything takes.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/runtime/cache_folder.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/opencl_context.h"
#include "kernels/runtime/program_cache.h"
#include "tests/kernels/scoped_variable.h"

namespace egosieve::kernels {
namespace {

constexpr char kKey[] = "a key of the size of some source text\n";
constexpr size_t kBinaryBytes = 100000;

// A binary that tells whether it is whole: one byte, over and over, and as long as that byte says.
std::string Binary(int number) {
  const unsigned char byte = static_cast<unsigned char>(number % 251 + 1);
  return std::string(kBinaryBytes + byte, static_cast<char>(byte));
}

bool IsWhole(const std::string& binary) {
  return !binary.empty() && binary == Binary(static_cast<unsigned char>(binary[0]) - 1);
}

// Runs `body` in a process of its own, which ends with its result as exit code.
pid_t Spawn(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) _exit(body());
  return child;
}

int WaitFor(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

bool EndedWell(int status) { return WIFEXITED(status) && WEXITSTATUS(status) == 0; }

class CacheCrashTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        testing::TempDir() + "/" + testing::UnitTest::GetInstance()->current_test_info()->name();
    cache_.emplace("EGOSIEVE_CACHE_DIR", folder_);
  }

  int FilesEndingWith(const std::string& suffix) const {
    int count = 0;
    std::error_code missing;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ + "/programs", missing)) {
      count += entry.path().extension() == suffix ? 1 : 0;
    }
    return count;
  }

  std::string folder_;
  std::optional<ScopedVariable> cache_;
};

TEST_F(CacheCrashTest, ReadersAmongWritersSeeWholeBinaries) {
  constexpr int kProcesses = 4, kStores = 60;
  StoreBinary(kKey, Binary(0));
  std::vector<pid_t> children;
  for (int process = 0; process < kProcesses; ++process) {
    children.push_back(Spawn([process] {
      for (int i = 0; i < kStores; ++i) {
        StoreBinary(kKey, Binary(process * kStores + i));
        for (int read = 0; read < 3; ++read) {
          if (!IsWhole(LoadBinary(kKey))) return 1;
        }
      }
      return 0;
    }));
  }
  for (const pid_t child : children) EXPECT_TRUE(EndedWell(WaitFor(child)));
  EXPECT_TRUE(IsWhole(LoadBinary(kKey)));
  EXPECT_EQ(FilesEndingWith(".bin"), 1);
  EXPECT_EQ(FilesEndingWith(".tmp"), 0);
}

// The system ends a process with a signal at the first byte that it writes past its limit.
TEST_F(CacheCrashTest, AProcessThatDiesAtAnyByteOfWritingChangesNothing) {
  StoreBinary(kKey, Binary(1));
  int died = 0;
  for (const rlim_t bytes : {rlim_t{0}, rlim_t{1}, rlim_t{20}, rlim_t{4096}, rlim_t{8191},
                             rlim_t{50000}, rlim_t{kBinaryBytes}}) {
    const int status = WaitFor(Spawn([bytes] {
      const rlimit core = {0, 0};
      setrlimit(RLIMIT_CORE, &core);
      const rlimit limit = {bytes, bytes};
      signal(SIGXFSZ, SIG_DFL);
      setrlimit(RLIMIT_FSIZE, &limit);
      StoreBinary(kKey, Binary(2));
      return 0;
    }));
    died += WIFSIGNALED(status) ? 1 : 0;
    EXPECT_EQ(LoadBinary(kKey), Binary(1)) << "died after " << bytes << " bytes";
  }
  EXPECT_EQ(died, 7);
  EXPECT_EQ(FilesEndingWith(".tmp"), died);  // each died in the middle of its file
  StoreBinary(kKey, Binary(2));
  EXPECT_EQ(LoadBinary(kKey), Binary(2));
}

TEST_F(CacheCrashTest, WritersThatAreKilledLeaveAWholeBinary) {
  for (int round = 0; round < 20; ++round) {
    int pipe_ends[2];
    ASSERT_EQ(pipe(pipe_ends), 0);
    const pid_t child = Spawn([&] {
      for (int i = 0;; ++i) {
        StoreBinary(kKey, Binary(i));
        const char done = 0;
        if (write(pipe_ends[1], &done, 1) != 1) return 1;
      }
    });
    close(pipe_ends[1]);
    // Killed once some stores are done, wherever it is by then.
    for (int stores = 0; stores <= round; ++stores) {
      char done;
      ASSERT_EQ(read(pipe_ends[0], &done, 1), 1);
    }
    kill(child, SIGKILL);
    EXPECT_TRUE(WIFSIGNALED(WaitFor(child)));
    close(pipe_ends[0]);
    EXPECT_TRUE(IsWhole(LoadBinary(kKey))) << "round " << round;
  }
}

// What a file system may show after a loss of power: a file that was renamed but not yet written.
TEST_F(CacheCrashTest, FilesWithMissingPartsAreNotBelieved) {
  StoreBinary(kKey, Binary(7));
  const std::string path = ProgramPath(kKey);
  const std::string good = ReadCacheFile(path);
  const auto load = [&](const std::string& bytes) {
    EXPECT_TRUE(WriteCacheFile(path, bytes).ok());
    return LoadBinary(kKey);
  };
  constexpr size_t kBlock = 4096;
  for (size_t begin = 0; begin < good.size(); begin += kBlock) {
    const size_t size = std::min(kBlock, good.size() - begin);
    std::string lost = good;
    lost.replace(begin, size, size, '\0');
    EXPECT_EQ(load(lost), "") << "zeros from " << begin;
    EXPECT_EQ(load(good.substr(0, begin)), "") << "ends at " << begin;
    std::string flipped = good;
    flipped[begin + size / 2] = static_cast<char>(flipped[begin + size / 2] ^ 4);
    EXPECT_EQ(load(flipped), "") << "a bit of block " << begin / kBlock;
  }
  EXPECT_EQ(load(good + good), "");
  EXPECT_EQ(load(good + "x"), "");
  EXPECT_EQ(load(good), Binary(7));
}

TEST_F(CacheCrashTest, ProcessesThatBuildTheSameProgramAtOnceAllSucceed) {
  constexpr int kReference = 2;
  const auto build = [] {
    const auto context = OpenContext();
    if (!context.ok()) return 1;
    if ((*context)->is_reference()) return kReference;
    return (*context)
                   ->Kernel("image.cl", "-cl-std=CL1.2 -DVEC=1 -DCHANNELS=1", "grid_interpolation")
                   .ok()
               ? 0
               : 1;
  };
  std::vector<pid_t> children;
  for (int process = 0; process < 3; ++process) children.push_back(Spawn(build));
  bool reference = false;
  for (const pid_t child : children) {
    const int status = WaitFor(child);
    reference = reference || (WIFEXITED(status) && WEXITSTATUS(status) == kReference);
    EXPECT_TRUE(reference || EndedWell(status));
  }
  if (reference) GTEST_SKIP() << "the reference compiles nothing";
  EXPECT_EQ(FilesEndingWith(".bin"), 1);
  EXPECT_EQ(FilesEndingWith(".tmp"), 0);
}

}  // namespace
}  // namespace egosieve::kernels
