#include "tests/tools/lab/compare/made_comparison.h"

#include <gtest/gtest.h>

#include <cmath>

namespace egosieve::tools {

MethodResult MakeMethodResult(const std::string& name, const std::vector<double>& aucs) {
  MethodResult method{name, true, DriveScores({}), {}};
  for (size_t i = 0; i < aucs.size(); ++i) {
    ScoredFrame frame;
    frame.index = static_cast<int64_t>(i);
    frame.scattered = true;
    frame.truth = cv::Mat1b::zeros(1, 101);
    frame.truth(0, 100) = 255;
    frame.probability = cv::Mat1w(1, 101, uint16_t{60000});
    for (int k = 0; k < std::lround(100 * aucs[i]); ++k) frame.probability(0, k) = 100;
    frame.probability(0, 100) = 30000;
    EXPECT_TRUE(method.scores.Add(frame).ok());
    const std::optional<double> auc = method.scores.frames().back().auc;
    method.frames.push_back(
        {frame.index, auc, auc, static_cast<int64_t>(10 * i), 5.0 + static_cast<double>(i)});
  }
  return method;
}

DriveComparison MakeDrive(const std::string& name, const std::vector<double>& first,
                          const std::vector<double>& second, const std::string& rival) {
  DriveComparison drive;
  drive.sequence.name = name;
  drive.frames = static_cast<int64_t>(first.size());
  drive.methods = {MakeMethodResult("arcsine", first), MakeMethodResult(rival, second)};
  drive.shared_milliseconds.assign(first.size(), 100.0);
  return drive;
}

}  // namespace egosieve::tools
