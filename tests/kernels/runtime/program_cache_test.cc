#include "kernels/runtime/program_cache.h"

#include <cstdlib>
#include <filesystem>
#include <optional>

#include "gtest/gtest.h"
#include "kernels/runtime/cache_folder.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/kernels/scoped_variable.h"

namespace egosieve::kernels {
namespace {

constexpr char kFile[] = "image.cl";
constexpr char kKernel[] = "grid_interpolation";

class ProgramCacheTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        testing::TempDir() + "/" + testing::UnitTest::GetInstance()->current_test_info()->name();
    cache_.emplace("EGOSIEVE_CACHE_DIR", folder_);
  }

  // Builds a program in a context of its own; false when the device is the reference.
  bool Build(bool program_cache, const std::string& extra_options = "") {
    ContextOptions options;
    options.program_cache = program_cache;
    const auto context = OpenContext(options);
    EXPECT_TRUE(context.ok()) << context.status();
    if (!context.ok() || (*context)->is_reference()) return false;
    const auto kernel =
        (*context)->Kernel(kFile, "-cl-std=CL1.2 -DVEC=1 -DCHANNELS=1" + extra_options, kKernel);
    EXPECT_TRUE(kernel.ok()) << kernel.status();
    return true;
  }

  std::vector<std::string> Files() const {
    std::vector<std::string> files;
    std::error_code missing;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ + "/programs", missing)) {
      files.push_back(entry.path().string());
    }
    return files;
  }

  std::string folder_;
  std::optional<ScopedVariable> cache_;
};

TEST_F(ProgramCacheTest, AProgramIsStoredOnceAndUsedAgain) {
  if (!Build(true)) GTEST_SKIP() << "the reference compiles nothing";
  ASSERT_EQ(Files().size(), 1u);
  const auto written = std::filesystem::last_write_time(Files()[0]);
  Build(true);
  ASSERT_EQ(Files().size(), 1u);
  EXPECT_EQ(std::filesystem::last_write_time(Files()[0]), written);
  Build(true, " -DOTHER");
  EXPECT_EQ(Files().size(), 2u);
}

TEST_F(ProgramCacheTest, TheSwitchTurnsItOff) {
  Build(false);
  EXPECT_TRUE(Files().empty());
}

TEST_F(ProgramCacheTest, DamagedFilesAreReplaced) {
  if (!Build(true)) GTEST_SKIP() << "the reference compiles nothing";
  const std::string path = Files()[0];
  const std::string good = ReadCacheFile(path);
  std::string flipped = good;
  flipped[good.size() - 100] ^= 1;
  for (const std::string& damaged :
       {std::string(), good.substr(0, good.size() / 2), flipped, std::string("x")}) {
    ASSERT_TRUE(WriteCacheFile(path, damaged).ok());
    EXPECT_TRUE(Build(true));
    EXPECT_EQ(ReadCacheFile(path).size(), good.size());
  }
}

TEST_F(ProgramCacheTest, ABinaryThatTheDriverRefusesFallsBackToTheSource) {
  if (!Build(true)) GTEST_SKIP() << "the reference compiles nothing";
  // A whole file, hash and all, of a binary that is none.
  const std::string file = ReadCacheFile(Files()[0]);
  const size_t end_of_length = file.find('\n', file.find('\n') + 1);
  const size_t length = std::stoul(file.substr(file.find('\n') + 1));
  const std::string key = file.substr(end_of_length + 1, length);
  StoreBinary(key, "no binary at all");
  ASSERT_EQ(LoadBinary(key), "no binary at all");
  EXPECT_TRUE(Build(true));
  EXPECT_NE(LoadBinary(key), "no binary at all");
}

TEST_F(ProgramCacheTest, AFolderThatCannotBeWrittenIsNoError) {
  ASSERT_TRUE(WriteCacheFile(folder_, "a file where the folder should be").ok());
  Build(true);
  EXPECT_TRUE(Files().empty());
}

TEST_F(ProgramCacheTest, TheKeyCoversEverythingThatABinaryDependsOn) {
  const DeviceInfo device;
  const std::string key = ProgramKey(device, "source", "options");
  for (std::string DeviceInfo::*field :
       {&DeviceInfo::name, &DeviceInfo::vendor, &DeviceInfo::platform, &DeviceInfo::version,
        &DeviceInfo::driver}) {
    DeviceInfo other = device;
    other.*field = "other";
    EXPECT_NE(ProgramKey(other, "source", "options"), key);
  }
  EXPECT_NE(ProgramKey(device, "source 2", "options"), key);
  EXPECT_NE(ProgramKey(device, "source", "options 2"), key);
}

TEST_F(ProgramCacheTest, OneKeysBinaryIsNotAnothers) {
  StoreBinary("key one", "binary");
  EXPECT_EQ(LoadBinary("key one"), "binary");
  EXPECT_EQ(LoadBinary("key two"), "");
  // As if the two had the same hash.
  ASSERT_TRUE(WriteCacheFile(ProgramPath("key two"), ReadCacheFile(ProgramPath("key one"))).ok());
  EXPECT_EQ(LoadBinary("key two"), "");
}

}  // namespace
}  // namespace egosieve::kernels
