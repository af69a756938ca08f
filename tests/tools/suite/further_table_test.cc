#include "tools/suite/further_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

SequenceResult Result(const std::string& name, const std::string& profile) {
  SequenceResult result;
  result.sequence = {name, name, "", ""};
  result.profile = profile;
  return result;
}

// One moving car in a picture that is marked all over, or nowhere.
BoxScores OneCar(bool marked) {
  LabelledBox car;
  car.box_class = BoxClass::kVehicle;
  car.right = car.bottom = 8.0;
  car.moving = true;
  car.depth_metres = 15.0;
  BoxScores scores;
  scores.Add({car}, cv::Mat1f(10, 10, marked ? 1.0f : 0.0f), kernels::ImageGrid{10, 10, 1});
  return scores;
}

TEST(FurtherTable, BoxesArePooledByVariantAndCamerasStandByThemselves) {
  std::vector<SequenceResult> results = {Result("one", "default"), Result("one", "paper"),
                                         Result("two", "default"), Result("two", "paper")};
  EXPECT_EQ(FurtherTable(results), "");
  results[0].further.boxes = OneCar(true);
  results[1].further.boxes = OneCar(false);
  results[2].further.boxes = OneCar(false);
  EXPECT_THAT(FurtherTable(results), HasSubstr("default, all sequences with boxes"));
  EXPECT_THAT(FurtherTable(results), HasSubstr("1 of 2 0.50"));
  EXPECT_THAT(FurtherTable(results), HasSubstr("0 of 1 0.00"));
  EXPECT_THAT(FurtherTable(results), Not(HasSubstr("rotation")));
  results[2].further.trajectory = TrajectoryErrors{12, 0.25, std::nullopt, 5, 1.5};
  results[2].further.shifted = TrajectoryErrors{11, 0.05, std::nullopt, 5, 0.5};
  results[2].further.row_shift = 1;
  const std::string table = FurtherTable(results);
  EXPECT_THAT(table, HasSubstr("0.250            -        1.500"));
  EXPECT_THAT(table, HasSubstr("0.050            -        0.500"));
}

}  // namespace
}  // namespace egosieve::tools
