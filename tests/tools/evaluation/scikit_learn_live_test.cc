// Random arrays through this library and through Debian's python3-sklearn, side by side. Skipped
// where that is not installed; scikit_learn_test holds values that were written down once.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <random>
#include <sstream>
#include <string>

#include "tools/evaluation/calibration.h"
#include "tools/evaluation/roc.h"

namespace egosieve::tools {
namespace {

constexpr char kScript[] = R"(
import sys
try:
    import numpy as np
    from sklearn import metrics
except ImportError:
    print("missing")
    sys.exit(0)
rows = np.array([line.split() for line in open(sys.argv[1])], dtype=int)
score, truth = rows[:, 0], rows[:, 1]
called = score >= 30000
probability = score / 65535
print(*("%.17g" % value for value in (
    metrics.roc_auc_score(truth, score),
    metrics.average_precision_score(truth, score),
    metrics.f1_score(truth, called),
    metrics.jaccard_score(truth, called),
    metrics.brier_score_loss(truth, probability),
    metrics.log_loss(truth, np.clip(probability, 0.5 / 65535, 1 - 0.5 / 65535)))))
)";

struct Sample {
  RocHistogram scores;
  std::string rows;
};

// `levels` different scores: few make many ties.
Sample Draw(uint64_t seed, int count, int levels) {
  std::mt19937_64 random(seed);
  Sample sample;
  for (int i = 0; i < count; ++i) {
    const bool positive = random() % 5 == 0;
    const uint64_t level = (random() % levels + random() % levels + (positive ? levels : 0)) / 3;
    const auto score = static_cast<uint16_t>(level * 65535 / static_cast<uint64_t>(levels));
    sample.scores.Add(score, positive);
    sample.rows += std::to_string(score) + (positive ? " 1\n" : " 0\n");
  }
  return sample;
}

std::string Output(const std::string& command) {
  std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string output;
  char buffer[256];
  while (pipe != nullptr && fgets(buffer, sizeof buffer, pipe.get()) != nullptr) output += buffer;
  return output;
}

void WriteFile(const std::string& path, const std::string& text) {
  FILE* file = std::fopen(path.c_str(), "w");
  ASSERT_NE(file, nullptr);
  std::fputs(text.c_str(), file);
  std::fclose(file);
}

TEST(ScikitLearn, GivesTheSameValuesForTheSameArrays) {
  const std::string script = testing::TempDir() + "/metrics.py";
  const std::string rows = testing::TempDir() + "/rows.txt";
  WriteFile(script, kScript);
  for (const int levels : {7, 300, 50000}) {
    const Sample sample = Draw(static_cast<uint64_t>(levels), 3000, levels);
    WriteFile(rows, sample.rows);
    const std::string output = Output("/usr/bin/python3 " + script + " " + rows + " 2>/dev/null");
    if (output.empty() || output == "missing\n") GTEST_SKIP() << "python3-sklearn is not installed";
    std::istringstream values(output);
    double auc, average_precision, f, iou, brier, log_loss;
    values >> auc >> average_precision >> f >> iou >> brier >> log_loss;
    ASSERT_TRUE(values) << output;
    const Confusion confusion = sample.scores.At(30000);
    const Calibration calibration = *CalibrationOf(sample.scores);
    // Sums of 3,000 terms of at most 12 by another order of operations: 3,000 x 12 eps = 8e-12.
    EXPECT_NEAR(*sample.scores.Auc(), auc, 1e-11) << levels;
    EXPECT_NEAR(*sample.scores.AveragePrecision(), average_precision, 1e-11) << levels;
    EXPECT_NEAR(*confusion.F(), f, 1e-11) << levels;
    EXPECT_NEAR(*confusion.Iou(), iou, 1e-11) << levels;
    EXPECT_NEAR(calibration.brier, brier, 1e-11) << levels;
    EXPECT_NEAR(calibration.log_loss, log_loss, 1e-11) << levels;
  }
}

}  // namespace
}  // namespace egosieve::tools
