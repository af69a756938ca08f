#include "vision/baselines/optical_flow_classifier.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <variant>
#include <vector>

#include "tests/vision/labelling/feature_evaluation.h"
#include "vision/frame/frame_source.h"
#include "vision/geometry/residual.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {
namespace {

constexpr int kWidth = 1200, kHeight = 400;
constexpr double kFocal = 800, kCameraHeight = 1.5, kStep = 1.0;  // metres forward

// A camera that goes straight ahead over a road between walls.
PointPair Project(double x, double y, double z, double moved = 0.0) {
  const double cx = 0.5 * (kWidth - 1), cy = 0.5 * (kHeight - 1);
  const double later = z + moved - kStep;
  return {kFocal * x / z + cx, kFocal * y / z + cy, kFocal * x / later + cx,
          kFocal * y / later + cy};
}

Eigen::Matrix3d ForwardFundamental() {
  const double cx = 0.5 * (kWidth - 1), cy = 0.5 * (kHeight - 1);
  Eigen::Matrix3d f;  // the epipole is the centre: [e]x
  f << 0, -1, cy, 1, 0, -cx, -cy, cx, 0;
  return f;
}

std::vector<PointPair> StaticScene() {
  std::vector<PointPair> pairs;
  for (int i = 0; i < 400; ++i) {
    const double z = 6 + 0.09 * i;
    pairs.push_back(Project(-2.5 + 0.0137 * (i * 37 % 400), kCameraHeight, z));  // the road
    pairs.push_back(Project(i % 2 == 0 ? -4 : 4, 1.4 - 0.01 * (i * 53 % 400), z));
  }
  return pairs;
}

OpticalFlowClassifierOptions Options() {
  OpticalFlowClassifierOptions options;
  options.focal_length_pixels = kFocal;
  return options;
}

TEST(ClassifyOpticalFlow, StaticWorldViolatesNothingAndItsRoadIsFound) {
  const auto result = ClassifyOpticalFlow(StaticScene(), MotionModelKind::kFundamental,
                                          ForwardFundamental(), kWidth, kHeight, Options());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_NEAR(result->road_height, kCameraHeight / kStep, 0.1 * kCameraHeight);
  for (const double violation : result->violation_pixels) EXPECT_LT(violation, 1e-6);
}

// What moves along the epipolar lines, which the lines alone cannot see.
TEST(ClassifyOpticalFlow, CarsInTheLaneViolateDepthOrHeight) {
  std::vector<PointPair> pairs = StaticScene();
  const size_t first = pairs.size();
  for (int i = 0; i < 20; ++i)
    pairs.push_back(Project(-0.8 + 0.08 * i, 0.5, 12, 1.6));  // pulls away
  for (int i = 0; i < 20; ++i)
    pairs.push_back(Project(2.0 + 0.05 * i, 1.2, 12, 0.5));  // slower, ahead
  const auto result = ClassifyOpticalFlow(pairs, MotionModelKind::kFundamental,
                                          ForwardFundamental(), kWidth, kHeight, Options());
  ASSERT_TRUE(result.ok());
  for (size_t i = first; i < first + 20; ++i) {
    // Least at x = 0: 33.3 pixels below the epipole, moved up 1.59 where the road would move down
    // 0.95; less the tolerance of 1.
    EXPECT_GT(result->violation_pixels[i], 1.5) << i - first;
  }
  for (size_t i = first + 20; i < pairs.size(); ++i) {
    EXPECT_GT(result->violation_pixels[i], 2.0) << i - first;
  }
  for (const double residual : Residuals(MotionModelKind::kFundamental, ForwardFundamental(), pairs,
                                         EpipolarDistance::kPointToLine)) {
    EXPECT_LT(residual, 1e-6);
  }
}

TEST(ClassifyOpticalFlow, WithoutTranslationTheResidualDecides) {
  const std::vector<PointPair> pairs = {{10, 10, 13, 14}};
  const auto result = ClassifyOpticalFlow(pairs, MotionModelKind::kHomography,
                                          Eigen::Matrix3d::Identity(), 100, 100, {});
  EXPECT_DOUBLE_EQ(result->violation_pixels[0], 5.0);
}

TEST(ClassifyOpticalFlow, DegenerateInputIsDefined) {
  for (const Eigen::Matrix3d& f :
       {Eigen::Matrix3d(Eigen::Matrix3d::Zero()), ForwardFundamental()}) {
    const auto empty = ClassifyOpticalFlow({}, MotionModelKind::kFundamental, f, 10, 10, {});
    ASSERT_TRUE(empty.ok());
    // At the epipole itself.
    const PointPair centre{0.5 * (kWidth - 1), 0.5 * (kHeight - 1), 0.5 * (kWidth - 1),
                           0.5 * (kHeight - 1)};
    const auto one = ClassifyOpticalFlow({centre, centre}, MotionModelKind::kFundamental, f, kWidth,
                                         kHeight, {});
    ASSERT_TRUE(one.ok());
    for (const double violation : one->violation_pixels) EXPECT_TRUE(std::isfinite(violation));
  }
  EXPECT_FALSE(ClassifyOpticalFlow({}, MotionModelKind::kStatic, {}, 0, 10, {}).ok());
  OpticalFlowClassifierOptions options;
  options.tolerance_pixels = NAN;
  EXPECT_FALSE(ClassifyOpticalFlow({}, MotionModelKind::kStatic, {}, 10, 10, options).ok());
}

// On driving clips (KT3DMoSeg; Xu, Cheong and Li, CVPR 2018): against the epipolar distance alone.
TEST(ClassifyOpticalFlow, OnRealDriving) {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name a folder of real data";
  double sum_epipolar = 0.0, sum_all = 0.0;
  for (const char* name : {"Seq005_Clip01", "Seq013_Clip02", "Seq028_Clip01"}) {
    const std::string folder = std::string(data) + "/kt3dmoseg/" + name;
    const auto tracks = ReadLabelledTracks(folder + "/tracks.csv", 1);
    auto source = OpenFrameSource(folder + "/frames");
    ASSERT_TRUE(tracks.ok() && source.ok());
    FrameLabellerOptions options;
    options.motion_model = MotionModelChoice::kFundamental;
    auto labeller = *FrameLabeller::Create(options);
    double epipolar = 0.0, all = 0.0;
    int frames = 0;
    for (int t = 0; t < 12; ++t) {
      const auto read = (*source)->Next();
      ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
      const Frame& frame = std::get<Frame>(*read);
      const auto labelled = labeller->Process(frame);
      ASSERT_TRUE(labelled.ok());
      if (labelled->outcome != LabelOutcome::kLabelled) continue;
      // R, t and the road from the whole image's matches, scores at the tracks.
      std::vector<PointPair> pairs;
      for (int64_t i = 0; i < labelled->size(); ++i) {
        pairs.push_back({labelled->other_positions[2 * i], labelled->other_positions[2 * i + 1],
                         labelled->positions[2 * i], labelled->positions[2 * i + 1]});
      }
      const size_t first = pairs.size();
      const TrackPairs truth =
          PairsOfTracks(*tracks, labelled->first_index, labelled->second_index);
      pairs.insert(pairs.end(), truth.pairs.begin(), truth.pairs.end());
      Eigen::Matrix3d f;
      for (int i = 0; i < 9; ++i) f(i / 3, i % 3) = labelled->motion_matrix(i / 3, i % 3);
      const auto result = ClassifyOpticalFlow(pairs, MotionModelKind::kFundamental, f,
                                              frame.image.cols, frame.image.rows, {});
      ASSERT_TRUE(result.ok());
      const std::vector<double> scores(result->violation_pixels.begin() + first,
                                       result->violation_pixels.end());
      const auto auc = AreaUnderRoc(scores, truth.is_mover);
      const auto plain = ScoreAgainstTracks(*labelled, *tracks).residual_auc;
      if (!auc.has_value() || !plain.has_value()) continue;
      all += *auc;
      epipolar += *plain;
      ++frames;
    }
    ASSERT_GT(frames, 5);
    std::printf("%-14s epipolar %.3f  all constraints %.3f\n", name, epipolar / frames,
                all / frames);
    sum_epipolar += epipolar / frames;
    sum_all += all / frames;
  }
  EXPECT_GT(sum_all / 3, 0.9);
  EXPECT_GT(sum_all, sum_epipolar - 3 * 0.03);
}

}  // namespace
}  // namespace egosieve::vision
