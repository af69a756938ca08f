// A drive learnt in pieces: each frame has the maps of the first piece that holds it.

#include <filesystem>

#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "tests/testing/fresh_folder.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

class Pieces : public testing::Test {
 protected:
  Pieces() : root_(FreshFolder()) { WritePatchDrive(root_, SmallPatchDrive(16)); }

  ProgramOutcome Segment(const std::string& name, const std::vector<std::string>& flags,
                         const std::string& input = "frames") const {
    return RunProgram(std::vector<std::string>{"segment", root_ + "/" + input,
                                               "--out=" + Folder(name), "--budget=100",
                                               "--stride=8", "--progress=none"} +
                      flags);
  }

  ProgramOutcome Merge(const std::vector<std::string>& names) const {
    std::vector<std::string> words = {"merge", "--progress=none"};
    for (const std::string& name : names) words.push_back(Folder(name));
    return RunProgram(words);
  }

  std::string Folder(const std::string& name) const { return root_ + "/" + name; }
  std::string Map(const std::string& name, int frame) const {
    return ReadFile(Folder(name) + absl::StrFormat("/grid/%06d.prob.png", frame)).value_or("none");
  }

  std::string root_;
};

TEST_F(Pieces, AreOneRunWhenTheyAreMerged) {
  ASSERT_THAT(Segment("first", {"--to=5"}), Succeeds());
  ASSERT_THAT(Segment("second", {"--from=3", "--to=10"}), Succeeds());
  ASSERT_THAT(Segment("third", {"--from=8"}), Succeeds());
  const std::string first_map = Map("first", 4);
  const ProgramOutcome merged = Merge({"first", "second", "third"});
  ASSERT_EQ(merged.code, 0) << merged.err;
  EXPECT_THAT(merged.out, HasSubstr("10 maps taken over"));
  const std::vector<FrameLine> lines = *RunFolder::Open(Folder("first"))->ReadLines();
  ASSERT_EQ(lines.size(), 16u);
  for (int i = 0; i < 16; ++i) EXPECT_EQ(lines[i].index, i);
  EXPECT_EQ(Map("first", 4), first_map);
  EXPECT_EQ(Map("first", 9), Map("second", 9));
  EXPECT_EQ(Map("first", 15), Map("third", 15));
  EXPECT_NE(Map("second", 9), Map("third", 9));
  // No copies.
  EXPECT_TRUE(std::filesystem::equivalent(Folder("first") + "/grid/000015.prob.png",
                                          Folder("third") + "/grid/000015.prob.png"));
  const ProgramOutcome whole = RunProgram({"refine", Folder("first"), "--progress=none"});
  EXPECT_EQ(whole.code, 0) << whole.err;
  EXPECT_THAT(whole.out, HasSubstr("16 frames refined"));
}

TEST_F(Pieces, OfOtherDrivesOrFlagsAreRefused) {
  WritePatchDrive(root_ + "/elsewhere", SmallPatchDrive(16));
  ASSERT_THAT(Segment("first", {"--to=3"}), Succeeds());
  ASSERT_THAT(Segment("other", {"--from=2", "--to=5"}, "elsewhere/frames"), Succeeds());
  ASSERT_THAT(Segment("finer", {"--from=2", "--to=5", "--set=frame_gap=2"}), Succeeds());
  for (const auto& [name, what] : {std::pair{"other", "the input"}, {"finer", "frame_gap"}}) {
    EXPECT_THAT(Merge({"first", name}), EndsWithLine(2, what)) << name;
  }
  // A run that begins where the first does, though it has more frames.
  ASSERT_THAT(Segment("same", {"--to=5"}), Succeeds());
  EXPECT_THAT(Merge({"first", "same"}).err,
              HasSubstr("is no later piece of the drive: both begin at frame 0"));
  EXPECT_EQ(RunFolder::Open(Folder("first"))->ReadLines()->size(), 4u);
}

}  // namespace
}  // namespace egosieve::tools
