
#include <cstdlib>
#include <string>

#include "tests/testing/status.h"
#include "tests/vision/evidence/clip_score.h"

namespace egosieve::vision {
namespace {

EvidenceOptions EpipolarAlone() {
  EvidenceOptions options;
  options.negative_depth = options.accumulation = false;
  return options;
}

// At the labelled tracks of three driving clips (KT3DMoSeg): movers against the rest. And the guess
// of the focal length must not matter.
TEST(LabelledClips, AllEvidenceTellsMoversFromTheRest) {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name the folder of the test data";
  constexpr int kGap = 2, kFrames = 11;
  double mean = 0.0, mean_epipolar = 0.0, calibration = 0.0;
  for (const char* name : {"Seq005_Clip01", "Seq013_Clip02", "Seq028_Clip01"}) {
    const auto clip = Value(LoadLabelledClip(std::string(data) + "/kt3dmoseg/" + name, kFrames));
    const auto motions = Value(FundamentalsOf(clip, kGap));
    const auto all = Value(ScoreClip(clip, motions, kGap, EvidenceOptions()));
    const auto epipolar = Value(ScoreClip(clip, motions, kGap, EpipolarAlone()));
    EXPECT_GT(all.auc, epipolar.auc) << name;
    EXPECT_GT(all.auc, 0.95) << name;
    mean += all.auc / 3;
    mean_epipolar += epipolar.auc / 3;
    calibration += all.calibration_error / 3;
    for (const double share : {0.58, 1.2}) {  // 0.58: the true one
      EvidenceOptions options;
      options.focal_pixels = share * clip.size.width;
      EXPECT_NEAR(ScoreClip(clip, motions, kGap, options)->auc, all.auc, 0.01)
          << name << " " << share;
    }
  }
  RecordProperty("all", std::to_string(mean));
  RecordProperty("epipolar", std::to_string(mean_epipolar));
  EXPECT_GT(mean, 0.98);
  EXPECT_LT(calibration, 0.06);
}

}  // namespace
}  // namespace egosieve::vision
