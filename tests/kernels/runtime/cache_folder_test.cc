#include "kernels/runtime/cache_folder.h"

#include <cstdlib>
#include <filesystem>

#include "gmock/gmock.h"
#include "kernels/runtime/tuning.h"
#include "tests/kernels/scoped_variable.h"

namespace egosieve::kernels {
namespace {

// A table of kernel shapes in the user's cache folder would decide what tests run.
TEST(CacheFolder, ThatOfTestsIsNotTheUsers) {
  EXPECT_EQ(CacheFolder(), "/dev/null/none");
  EXPECT_FALSE(WriteCacheFile(CacheFolder() + "/file", "x").ok());
}

TEST(CacheFolder, TheMostSpecificVariableWins) {
  const ScopedVariable home("HOME", "/h"), cache("XDG_CACHE_HOME"), own("EGOSIEVE_CACHE_DIR");
  unsetenv("XDG_CACHE_HOME");
  unsetenv("EGOSIEVE_CACHE_DIR");
  EXPECT_EQ(CacheFolder(), "/h/.cache/egosieve");
  setenv("XDG_CACHE_HOME", "/x", 1);
  EXPECT_EQ(CacheFolder(), "/x/egosieve");
  setenv("EGOSIEVE_CACHE_DIR", "/e", 1);
  EXPECT_EQ(CacheFolder(), "/e");
  setenv("EGOSIEVE_CACHE_DIR", "", 1);
  EXPECT_EQ(CacheFolder(), "/x/egosieve");
  unsetenv("XDG_CACHE_HOME");
  unsetenv("HOME");
  EXPECT_EQ(CacheFolder(), "");
}

TEST(HashBytes, IsFnv1a) {
  EXPECT_EQ(HashBytes(""), 0xcbf29ce484222325u);
  EXPECT_EQ(HashBytes("a"), 0xaf63dc4c8601ec8cu);
  EXPECT_EQ(HashBytes("foobar"), 0x85944171f73967e8u);
}

TEST(WriteCacheFile, MakesFoldersReplacesFilesAndLeavesNoTemporary) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "cache" / "below";
  const std::string path = (folder / "file").string();
  const std::string bytes("a\0b\n", 4);
  ASSERT_TRUE(WriteCacheFile(path, "old").ok());
  ASSERT_TRUE(WriteCacheFile(path, bytes).ok());
  EXPECT_EQ(ReadCacheFile(path), bytes);
  int files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++files;
  EXPECT_EQ(files, 1);
}

TEST(WriteCacheFile, SaysWhatCannotBeWritten) {
  const std::string file = testing::TempDir() + "/plain";
  ASSERT_TRUE(WriteCacheFile(file, "x").ok());
  const absl::Status status = WriteCacheFile(file + "/below", "x");
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(status.message(), testing::HasSubstr(file + "/below"));
  EXPECT_EQ(ReadCacheFile(file + "/below"), "");
}

TEST(Tuning, ATableIsReadBackForItsDeviceAlone) {
  const ScopedVariable folder("EGOSIEVE_CACHE_DIR", testing::TempDir() + "/tables");
  DeviceInfo device;
  device.name = "A device";
  DeviceInfo other = device;
  other.driver = "newer";
  KernelTuning tuning = DefaultTuning(8);
  EXPECT_EQ(LoadTuning(device, tuning), tuning);
  tuning.depth = 77;
  tuning.panel = 5;
  ASSERT_TRUE(SaveTuning(device, tuning).ok());
  EXPECT_EQ(LoadTuning(device, DefaultTuning(16)), tuning);
  EXPECT_EQ(LoadTuning(other, DefaultTuning(16)), DefaultTuning(16));
}

TEST(Tuning, DamagedTablesAreIgnored) {
  const KernelTuning defaults = DefaultTuning(16);
  for (const char* text : {"", "panel", "panel x", "panel 0", "panel 1000", "float_lanes 5",
                           "\xff\xfe\n\0", "panel 8 9", "unknown 3\n"}) {
    EXPECT_EQ(ParseTuning(text, defaults), defaults) << text;
  }
  EXPECT_EQ(ParseTuning("nonsense\npanel 9\nnonsense", defaults).panel, 9);
}

TEST(Tuning, DefaultsAreValid) {
  for (const int lanes : {1, 4, 8, 16}) EXPECT_TRUE(DefaultTuning(lanes).Validate().ok()) << lanes;
  EXPECT_TRUE(DefaultGpuTuning().Validate().ok());
  using Misfit = std::pair<int KernelTuning::*, int>;
  for (const auto& [field, value] :
       {Misfit{&KernelTuning::float_lanes, 4}, Misfit{&KernelTuning::work_group, 100},
        Misfit{&KernelTuning::panels_per_group, 12}, Misfit{&KernelTuning::depth, 24}}) {
    KernelTuning tuning = DefaultGpuTuning();
    tuning.*field = value;
    EXPECT_THAT(tuning.Validate().message(), testing::HasSubstr("local_tiles = 1"))
        << FormatTuning(tuning);
  }
  KernelTuning bad;
  bad.depth = 3;
  EXPECT_EQ(bad.Validate().message(), "depth = 3; it must be from 4 to 4096");
}

}  // namespace
}  // namespace egosieve::kernels
