// Labels on real video against hand-made truth (README.md of the data names the sources: DAVIS
// 2016, Perazzi et al., CVPR 2016; KT3DMoSeg, Xu, Cheong and Li, CVPR 2018, on KITTI raw).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tools/lab/evaluate_features/evaluate_features.h"
#include "tools/lab/evaluate_features/feature_report.h"

namespace egosieve::tools {
namespace {

// What plain OpenCV gives on the clip, the larger of two measurements: `egosieve lab
// evaluate_features`, and the data's own description.
double PlainAucOf(const std::string& clip) {
  if (clip == "kt3dmoseg/Seq005_Clip01") return 0.88;
  return clip == "kt3dmoseg/Seq013_Clip02" ? 0.95 : 0.90;
}

TEST(RealData, LabelsAndMotionModelsWithTheDefaultOptions) {
  const char* folder = std::getenv("EGOSIEVE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name a folder of real data";
  EvaluateFeaturesOptions options;
  options.plain_ransac = false;
  std::vector<SequenceScore> scores;
  int64_t judged = 0, not_below = 0;
  for (const char* kind : {"davis", "kt3dmoseg"}) {
    const auto sequences = FindFeatureSequences(std::string(folder) + "/" + kind);
    ASSERT_TRUE(sequences.ok()) << sequences.status();
    for (FeatureSequence sequence : *sequences) {
      sequence.name = std::string(kind) + "/" + sequence.name;
      const auto score = EvaluateSequence(sequence, options, [] { return true; });
      ASSERT_TRUE(score.ok()) << score.status();
      scores.push_back(*score);
      EXPECT_EQ(score->CountUnlabelled(), 0) << score->name;
      const double residual = MeanAuc(score->frames, ResidualAuc).value_or(0.0);
      const double label = MeanAuc(score->frames, LabelAuc).value_or(0.0);
      const double least = sequence.name[0] == 'd' ? 0.95 : PlainAucOf(sequence.name);
      EXPECT_GE(residual, least) << score->name;
      EXPECT_GE(label, least) << score->name;
      judged += std::count_if(score->frames.begin(), score->frames.end(),
                              [](const FeatureFrame& frame) { return frame.verdict.has_value(); });
      not_below += score->CountNotBelow();
    }
  }
  std::printf("%s", ToTable(scores).c_str());
  EXPECT_GE(static_cast<double>(not_below), 0.9 * static_cast<double>(judged));
}

}  // namespace
}  // namespace egosieve::tools
