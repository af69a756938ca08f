#include "tools/evaluation/mask_scores.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gtest/gtest.h"
#include "tools/evaluation/assignment.h"

namespace egosieve::tools {
namespace {

TEST(AssignLargest, TakesTheLargestSum) {
  const cv::Mat1d scores = (cv::Mat1d(2, 3) << 5.0, 4.0, 0.0, 4.5, 1.0, 0.0);
  EXPECT_EQ(AssignLargest(scores), (std::vector<int>{1, 0}));  // 8.5, not 5 + 1
  EXPECT_EQ(AssignLargest(scores.t()), (std::vector<int>{1, 0, -1}));
  EXPECT_EQ(AssignLargest(cv::Mat1d::zeros(1, 2)), (std::vector<int>{-1}));
}

// Objects of 100 pixels in their own rows of an image; an object covers the first `columns` columns
// of its 10 x 10 pixels.
void Put(cv::Mat1i& ids, int place, int number, int pixels = 100) {
  for (int i = 0; i < pixels; ++i) ids(10 * place + i / 10, i % 10) = number;
}

struct Pair {
  cv::Mat1i truth = cv::Mat1i::zeros(40, 10), predicted = cv::Mat1i::zeros(40, 10);
};

TEST(Identity, OfATrackThatIsBroken) {
  IdentityScorer scorer(1);
  for (int t = 0; t < 4; ++t) {
    Pair frame;
    Put(frame.truth, 0, 5);
    Put(frame.predicted, 0, t < 2 ? 1 : 2);
    scorer.Add(frame.truth, frame.predicted, {});
  }
  const IdentityScores scores = scorer.Score().value();
  EXPECT_DOUBLE_EQ(scores.idf1, 0.5);         // 2 of 4 frames by one number
  EXPECT_DOUBLE_EQ(scores.detection, 1.0);    // all pixels right
  EXPECT_DOUBLE_EQ(scores.association, 0.5);  // 2 / (4 + 2 - 2)
  EXPECT_NEAR(scores.hota, std::sqrt(0.5), 1e-12);
}

TEST(Identity, OfNumbersThatAreExchanged) {
  IdentityScorer scorer(1);
  for (int t = 0; t < 4; ++t) {
    Pair frame;
    Put(frame.truth, 0, 5);
    Put(frame.truth, 1, 6);
    Put(frame.predicted, 0, t < 2 ? 1 : 2);
    Put(frame.predicted, 1, t < 2 ? 2 : 1);
    scorer.Add(frame.truth, frame.predicted, {});
  }
  const IdentityScores scores = scorer.Score().value();
  EXPECT_DOUBLE_EQ(scores.idf1, 0.5);
  EXPECT_NEAR(scores.association, 1.0 / 3.0, 1e-12);  // 2 / (4 + 4 - 2)
}

TEST(Identity, OfAPartAndAFalseObject) {
  IdentityScorer scorer(1);
  for (int t = 0; t < 4; ++t) {
    Pair frame;
    Put(frame.truth, 0, 5);
    Put(frame.predicted, 0, 1, 62);  // IoU 0.62
    if (t < 2) Put(frame.predicted, 2, 9);
    scorer.Add(frame.truth, frame.predicted, {});
  }
  const IdentityScores scores = scorer.Score().value();
  EXPECT_DOUBLE_EQ(scores.idf1, 0.8);  // 2 * 4 / (4 + 6)
  // Twelve of the nineteen thresholds, 0.05 to 0.60, find it: 4 of 4 + 2.
  EXPECT_NEAR(scores.detection, 12.0 / 19.0 * 4.0 / 6.0, 1e-12);
  EXPECT_NEAR(scores.hota, 12.0 / 19.0 * std::sqrt(4.0 / 6.0), 1e-12);
}

TEST(Identity, LeavesSmallAndVoidOnesOut) {
  IdentityScorer scorer(50);
  Pair frame;
  Put(frame.truth, 0, 5, 49);
  Put(frame.predicted, 0, 1, 49);
  Put(frame.predicted, 2, 2);
  cv::Mat1b void_pixels = cv::Mat1b::zeros(frame.truth.size());
  void_pixels.rowRange(20, 30) = 255;
  scorer.Add(frame.truth, frame.predicted, void_pixels);
  EXPECT_FALSE(scorer.Score().has_value());
}

cv::Mat1b Disc(cv::Point centre, int radius) {
  cv::Mat1b mask = cv::Mat1b::zeros(200, 300);
  cv::circle(mask, centre, radius, cv::Scalar(255), cv::FILLED);
  return mask;
}

TEST(OutlineChange, IsOfShapeAndNotOfPlace) {
  const auto disc = DescribeOutline(Disc({100, 100}, 50));
  EXPECT_NEAR(*OutlineChange(disc, DescribeOutline(Disc({137, 91}, 50))), 0.0, 1e-6);
  const cv::Mat1b rough = Disc({100, 100}, 50);
  for (int k = 0; k < 12; ++k) {
    const cv::Point at(100 + static_cast<int>(50 * std::cos(k * 0.5236)),
                       100 + static_cast<int>(50 * std::sin(k * 0.5236)));
    cv::circle(rough, at, 12, cv::Scalar(k % 2 == 0 ? 255 : 0), cv::FILLED);
  }
  const double change = *OutlineChange(disc, DescribeOutline(rough));
  EXPECT_GT(change, 0.05);
  EXPECT_LT(*OutlineChange(disc, DescribeOutline(Disc({100, 100}, 52))), 0.5 * change);
  EXPECT_FALSE(OutlineChange(disc, DescribeOutline(Disc({-90, -90}, 5))).has_value());
}

TEST(MaskScores, OfAHalf) {
  MaskScores scores{ObjectOptions()};
  MaskFrame frame;
  frame.truth = cv::Mat1b::zeros(100, 100);
  frame.truth(cv::Rect(20, 20, 40, 40)) = 255;
  frame.mask = cv::Mat1b::zeros(100, 100);
  frame.mask(cv::Rect(20, 20, 40, 20)) = 255;
  ASSERT_TRUE(scores.Add(frame).ok());
  frame.index = 1;
  ASSERT_TRUE(scores.Add(frame).ok());
  EXPECT_DOUBLE_EQ(scores.MeanJ().value(), 0.5);
  EXPECT_LT(scores.MeanF().value(), 1.0);
  EXPECT_NEAR(scores.MeanT().value(), 0.0, 1e-6);  // nothing changes
  EXPECT_FALSE(scores.Identity().has_value());
  frame.mask = cv::Mat1b::zeros(10, 10);
  EXPECT_EQ(scores.Add(frame).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(scores.frames(), 2);
}

// A car is found by three quarters, a pedestrian by two fifths; a third number lies on nothing.
TEST(MaskScores, CountsTheMoversThatNumbersFind) {
  const std::map<int, SyntheticObject> objects = {
      {5, {5, "car", "ahead", true, 12.0, 100}},
      {6, {6, "pedestrian", "crossing", true, 20.0, 100}}};
  MaskFrame frame;
  frame.truth_ids = cv::Mat1i::zeros(40, 10);
  frame.ids = cv::Mat1i::zeros(40, 10);
  Put(frame.truth_ids, 0, 5);
  Put(frame.truth_ids, 1, 6);
  Put(frame.ids, 0, 1, 75);
  Put(frame.ids, 1, 2, 40);
  Put(frame.ids, 3, 3, 20);
  frame.truth = (frame.truth_ids != 0) & 255;
  frame.mask = (frame.ids != 0) & 255;
  frame.objects = &objects;
  MaskScores scores{ObjectOptions()};
  ASSERT_TRUE(scores.Add(frame).ok());
  const auto& recall = scores.objects().recall();
  EXPECT_EQ(recall.at("all").objects, 2);
  EXPECT_EQ(recall.at("vehicle within 40 m").found_at_50, 1);
  EXPECT_EQ(recall.at("person within 25 m").found_at_50, 0);
  EXPECT_EQ(recall.at("person within 25 m").found_at_30, 1);
  EXPECT_EQ(scores.objects().FalseObjectsPerFrame(), 1.0);
  EXPECT_DOUBLE_EQ(scores.ToJson().at("object_recall").at("all").at("mean_iou"), 0.575);
  EXPECT_EQ(scores.ToJson().at("false_objects_per_frame"), 1.0);
}

}  // namespace
}  // namespace egosieve::tools
