#include "tools/evaluate/potential_scores.h"

#include <fstream>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/tools/testing/fake_run.h"

namespace egosieve::tools {
namespace {

LabelledBox Box(double left, double top, double right, double bottom, std::optional<bool> moving) {
  LabelledBox box;
  box.box_class = BoxClass::kVehicle;
  box.left = left;
  box.top = top;
  box.right = right;
  box.bottom = bottom;
  box.moving = moving;
  return box;
}

// Grid pixels every 5: the box's middle, with 0.6 of its sides, holds x 10 .. 20 and y 10 .. 20.
TEST(PotentialScores, KindsOfPixelsByBoxes) {
  const kernels::ImageGrid grid{61, 41, 5};
  const auto at = [&](const std::vector<std::string>& kinds, int x, int y) {
    return kinds[(y / 5) * grid.columns() + x / 5];
  };
  std::vector<std::string> kinds = KindsByBoxes({Box(5, 5, 25, 25, false)}, grid, 0.6);
  EXPECT_EQ(at(kinds, 15, 15), "standing vehicle");
  EXPECT_EQ(at(kinds, 10, 20), "standing vehicle");
  EXPECT_EQ(at(kinds, 5, 15), "void");
  EXPECT_EQ(at(kinds, 30, 15), "");
  kinds = KindsByBoxes({Box(5, 5, 25, 25, false), Box(15, 15, 45, 45, true)}, grid, 0.6);
  EXPECT_EQ(at(kinds, 15, 15), "void");  // of one box or of the other
  EXPECT_EQ(at(kinds, 30, 30), "moving vehicle");
  kinds = KindsByBoxes({Box(5, 5, 25, 25, std::nullopt)}, grid, 0.6);
  EXPECT_EQ(at(kinds, 15, 15), "void");
}

TEST(PotentialScores, AreasByHand) {
  PotentialScores scores;
  EXPECT_TRUE(scores.empty());
  const cv::Mat1f potential = (cv::Mat1f(1, 6) << 0.9f, 0.4f, 0.5f, 0.3f, 1.0f, 0.2f);
  scores.Add(potential, {"standing vehicle", "standing vehicle", "", "", "void", "moving person"});
  EXPECT_EQ(scores.Auc("standing vehicle"), 0.75);  // 0.9 above both, 0.4 above one of two
  EXPECT_EQ(scores.Auc("moving person"), 0.0);
  EXPECT_EQ(scores.Auc("cyclist"), std::nullopt);
  EXPECT_EQ(scores.ToJson()["kinds"]["standing vehicle"]["pixels"], 2);
  EXPECT_EQ(scores.ToJson()["scenery_pixels"], 2);
}

// Only frames from `from_seconds` on count; frames of the fake run are 1/25 s apart.
TEST(PotentialScores, OfARunAgainstItsBoxes) {
  const std::string root = testing::TempDir() + "/potential_scores";
  const FakeRun run = WriteFakeRun(root);
  std::ofstream(root + "/boxes.csv") << "frame,id,type,x1,y1,x2,y2,moving\n"
                                        "1,0,Car,10,10,50,50,0\n4,0,Car,10,10,50,50,0\n";
  const auto score = [&](double from) {
    return ScorePotential(run.folder, "", root + "/boxes.csv", {from, 0.6});
  };
  EXPECT_TRUE(score(0.0)->empty());  // a run without potential
  RunDescription description = run.description;
  description.flags["potential"] = "yes";
  ASSERT_TRUE(run.folder.WriteDescription(description).ok());
  EXPECT_FALSE(score(0.0).ok());  // whose maps are missing
  const kernels::ImageGrid& grid = description.grid;
  const absl::StatusOr<std::vector<FrameLine>> lines = run.folder.ReadLines();
  ASSERT_TRUE(lines.ok()) << lines.status();
  for (const FrameLine& line : *lines) {
    FrameMaps maps;
    maps.probability = cv::Mat1f(grid.rows(), grid.columns(), 0.5f);
    maps.potential = cv::Mat1f(grid.rows(), grid.columns(), 0.2f);
    // The middle holds x and y from 18 to 42. Frame 4 has it the wrong way round.
    maps.potential(cv::Range(4, 9), cv::Range(4, 9)) = line.index == 4 ? 0.1f : 0.8f;
    ASSERT_TRUE(run.folder.WriteGridMaps(line.index, maps, 1.0).ok());
  }
  EXPECT_EQ(score(0.1)->Auc("standing vehicle"), 0.0);
  EXPECT_EQ(score(0.0)->Auc("standing vehicle"), 0.5);
  EXPECT_TRUE(score(10.0)->empty());
}

}  // namespace
}  // namespace egosieve::tools
