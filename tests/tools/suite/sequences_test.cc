#include "tools/suite/sequences.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class FindSequencesTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = (fs::path(testing::TempDir()) /
             testing::UnitTest::GetInstance()->current_test_info()->name())
                .lexically_normal()
                .string();
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  void Folder(const std::string& path) { fs::create_directories(root_ + "/" + path); }
  void File(const std::string& path) { std::ofstream(root_ + "/" + path) << "x"; }

  std::string root_;
};

TEST_F(FindSequencesTest, EachFormOfTruthIsFound) {
  Folder("davis/cows/frames");
  Folder("davis/cows/masks");
  Folder("kitti/frames");
  Folder("kitti/labels");
  Folder("tracks/one/frames");
  File("tracks/one/tracks.csv");
  Folder("synthetic/deep/street/frames");
  Folder("synthetic/deep/street/masks");
  File("synthetic/deep/street/scene.json");
  Folder("video/clip");
  Folder("bare/frames");
  Folder("interrupted/frames");
  Folder("interrupted/masks");
  File("interrupted/unfinished");
  const auto list = FindSequences(root_ + "/");
  ASSERT_TRUE(list.ok()) << list.status();
  ASSERT_EQ(list->sequences.size(), 4u);
  EXPECT_EQ(list->sequences[0].name, "davis/cows");
  EXPECT_EQ(list->sequences[0].group, "davis");
  EXPECT_EQ(list->sequences[0].frames, root_ + "/davis/cows/frames");
  EXPECT_EQ(list->sequences[0].truth, root_ + "/davis/cows/masks");
  EXPECT_EQ(list->sequences[1].name, "kitti");
  EXPECT_EQ(list->sequences[1].group, "kitti");
  EXPECT_EQ(list->sequences[1].truth, root_ + "/kitti/labels");
  EXPECT_EQ(list->sequences[2].name, "synthetic/deep/street");
  EXPECT_EQ(list->sequences[2].truth, root_ + "/synthetic/deep/street");
  EXPECT_EQ(list->sequences[3].truth, root_ + "/tracks/one/tracks.csv");
  EXPECT_THAT(list->without_truth, ElementsAre("bare", "interrupted"));
}

TEST_F(FindSequencesTest, ASequenceIsASuiteOfOne) {
  Folder("frames");
  Folder("masks");
  const auto list = FindSequences(root_);
  ASSERT_TRUE(list.ok()) << list.status();
  EXPECT_EQ(list->sequences[0].name, "ASequenceIsASuiteOfOne");
}

TEST_F(FindSequencesTest, NothingToFindIsSaid) {
  EXPECT_EQ(FindSequences(root_ + "/nowhere").status().code(), absl::StatusCode::kNotFound);
  Folder("bare/frames");
  const auto list = FindSequences(root_);
  EXPECT_EQ(list.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(list.status().message()), HasSubstr("frames without truth: bare"));
}

}  // namespace
}  // namespace egosieve::tools
