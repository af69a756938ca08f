// Sparse models against the exact one on a frame of real video: descriptors of random pixels,
// labels from the mask of what moves with a tenth of them wrong.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "kernels/ops/box_means.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

constexpr int64_t kTraining = 2000;
constexpr int64_t kQueries = 4000;

struct Frame {
  RowMatrix inputs;            // kTraining + kQueries
  std::vector<double> truth;   // of each
  std::vector<double> labels;  // of the first kTraining
};

// Half of the pixels on the mover, as far as it goes, so that the curve is well determined.
Frame SampleFrame(const cv::Mat& image, const cv::Mat& mask, std::mt19937_64& generator) {
  Frame frame;
  RowMatrix pixels(kTraining + kQueries, 2);
  for (int64_t i = 0; i < pixels.rows(); ++i) {
    const bool want = generator() % 2 == 0;
    for (int attempt = 0; attempt < 100; ++attempt) {
      const int x = static_cast<int>(generator() % image.cols);
      const int y = static_cast<int>(generator() % image.rows);
      pixels(i, 0) = x;
      pixels(i, 1) = y;
      if ((mask.at<uint8_t>(y, x) > 127) == want) break;
    }
    frame.truth.push_back(
        mask.at<uint8_t>(static_cast<int>(pixels(i, 1)), static_cast<int>(pixels(i, 0))) > 127);
    const bool wrong = generator() % 10 == 0;
    if (i < kTraining) frame.labels.push_back(wrong ? 1.0 - frame.truth[i] : frame.truth[i]);
  }
  const kernels::ImageView view{image.data, image.cols, image.rows, 3,
                                static_cast<ptrdiff_t>(image.step)};
  NarrowMatrix descriptors(pixels.rows(), 6);
  EXPECT_EQ(kernels::BoxMeansAt(*TestContext(), view, ViewOf(pixels), {},
                                {descriptors.data(), descriptors.rows(), descriptors.cols()}),
            absl::OkStatus());
  frame.inputs = descriptors.cast<double>();
  return frame;
}

std::vector<double> Probabilities(const Prediction& prediction, const LeaveOneOut& left_out,
                                  const Hyperparameters& theta, const std::vector<double>& labels) {
  const auto fit = Value(FitSquash(left_out.mean, left_out.LatentVariance(theta.noise_variance()),
                                   labels, {1.0, 0.0}));
  std::vector<double> probabilities;
  for (size_t i = 0; i < prediction.mean.size(); ++i) {
    probabilities.push_back(fit.parameters.Probability(prediction.mean[i], prediction.variance[i]));
  }
  return probabilities;
}

std::vector<double> SortedDifferences(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> differences;
  for (size_t i = 0; i < a.size(); ++i) differences.push_back(std::abs(a[i] - b[i]));
  std::sort(differences.begin(), differences.end());
  return differences;
}

TEST(SparseRealFrame, LosesLittleAgainstTheExactModel) {
  const char* folder = std::getenv("EGOSIEVE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA is not set";
  const std::string sequence = std::string(folder) + "/davis/car-shadow/";
  const cv::Mat image = cv::imread(sequence + "frames/00000.jpg", cv::IMREAD_COLOR);
  const cv::Mat mask = cv::imread(sequence + "masks/00000.png", cv::IMREAD_GRAYSCALE);
  if (image.empty() || mask.empty()) GTEST_SKIP() << "no frames in " << sequence;
  auto generator = TestGenerator();
  const Frame frame = SampleFrame(image, mask, generator);
  const kernels::ConstMatrixView<double> x = ViewOf(frame.inputs);
  const auto training = x.rows_between(0, kTraining);
  const auto queries = x.rows_between(kTraining, kTraining + kQueries);
  const Hyperparameters theta = DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, 6);

  auto exact = ExactModel::Create(TestContext(), theta);
  ASSERT_TRUE(exact->Add(training, frame.labels, 0).ok());
  const auto exact_prediction = Value(exact->Predict(queries, PredictWhat::kMeanAndVariance));
  const std::vector<double> expected =
      Probabilities(exact_prediction, *exact->PredictLeaveOneOut(), theta, frame.labels);
  const double area = AreaUnderCurve(expected, frame.truth.data() + kTraining);
  std::printf("exact: n = %d, AUC %.4f\n", static_cast<int>(kTraining), area);

  struct Case {
    const char* name;
    SparseApproximation approximation;
    int64_t inducing;
  };
  using A = SparseApproximation;
  for (const Case& c :
       {Case{"DTC", A::kDtc, 512}, Case{"FITC", A::kFitc, 512}, Case{"DTC", A::kDtc, 128}}) {
    SparseModelOptions options;
    options.approximation = c.approximation;
    options.inducing_points = c.inducing;
    auto model = Value(SparseModel::Create(TestContext(), theta, options));
    ASSERT_TRUE(model.Add(training, frame.labels, 0).ok());
    const auto prediction = Value(model.Predict(queries, PredictWhat::kMeanAndVariance));
    const std::vector<double> found =
        Probabilities(prediction, model.PredictLeaveOneOut(), theta, frame.labels);
    const std::vector<double> differences = SortedDifferences(found, expected);
    const double mean =
        std::accumulate(differences.begin(), differences.end(), 0.0) / differences.size();
    const double loss = area - AreaUnderCurve(found, frame.truth.data() + kTraining);
    std::printf(
        "%-4s m = %3d: probability differs by %.4f (mean), %.4f (99th percentile), "
        "AUC loss %.5f\n",
        c.name, static_cast<int>(c.inducing), mean, differences[differences.size() * 99 / 100],
        loss);
    EXPECT_LE(loss, 0.01) << c.name;
  }
}

}  // namespace
}  // namespace egosieve::gp
