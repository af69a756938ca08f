#include "vision/segmentation/frame_calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "gp/covariance/hyperparameters.h"
#include "kernels/runtime/context.h"
#include "tests/testing/status.h"
#include "vision/segmentation/learner_model.h"
#include "vision/segmentation/rows.h"

namespace egosieve::vision {
namespace {

// Places of a line from -1 to 1; what lies right of 0.8 moves: a tenth. The model holds every 20th.
class FrameCalibration : public testing::Test {
 protected:
  static constexpr int kPlaces = 1000;

  void SetUp() override {
    std::vector<int64_t> held;
    for (int i = 0; i < kPlaces; ++i) {
      const float x = 2.0f * (static_cast<float>(i) + 0.5f) / kPlaces - 1.0f;
      inputs_.insert(inputs_.end(), {x, 0.1f});
      labels_.push_back(x > 0.8f ? 0.95 : 0.01);
      if (i % 20 == 10) held.push_back(i);
    }
    left_ = Complement(kPlaces, held);
    const auto context = Value(kernels::OpenContext());
    const auto theta =
        gp::DefaultHyperparameters(kernels::CovarianceFunction::kSquaredExponential, 2);
    auto model = LearnerModel::Create(context, theta, {});
    ASSERT_TRUE(model.ok()) << model.status();
    const std::vector<float> points = GatherRows(Inputs(), held);
    ASSERT_TRUE(model
                    ->Add(kernels::ConstMatrixView<float>(points.data(),
                                                          static_cast<int64_t>(held.size()), 2),
                          Gather(labels_, held), 0)
                    .ok());
    posterior_ = Value(model->MakePosterior({}));
  }

  kernels::ConstMatrixView<float> Inputs() const {
    return kernels::ConstMatrixView<float>(inputs_.data(), kPlaces, 2);
  }

  std::vector<float> inputs_;
  std::vector<double> labels_;
  std::vector<int64_t> left_;
  std::shared_ptr<const gp::Posterior> posterior_;
};

TEST_F(FrameCalibration, ProbabilitiesFollowTheFramesOwnPlacesAndShare) {
  const auto squash = Value(FitSquashToFrame(*posterior_, Inputs(), labels_, left_, 400, 1, {}));
  std::vector<float> mean(kPlaces), variance(kPlaces);
  kernels::PosteriorOutputs outputs;
  outputs.mean = mean.data();
  outputs.variance = variance.data();
  ASSERT_TRUE(posterior_->Evaluate(Inputs(), outputs).ok());
  double sum = 0.0, labels = 0.0, before = 0.0;
  for (int i = 0; i < kPlaces; ++i) {
    sum += squash.Probability(mean[i], variance[i]);
    before += gp::SquashParameters().Probability(mean[i], variance[i]);
    labels += labels_[i];
  }
  // A probit with a free offset matches means nearly, not exactly.
  EXPECT_NEAR(sum / kPlaces, labels / kPlaces, 0.02);
  EXPECT_GT(std::abs(before - labels) / kPlaces, 0.04);
  EXPECT_GT(squash.Probability(mean[970], variance[970]), 0.7);
  EXPECT_LT(squash.Probability(mean[500], variance[500]), 0.05);
}

TEST_F(FrameCalibration, SameSeedSameFit) {
  const auto one = Value(FitSquashToFrame(*posterior_, Inputs(), labels_, left_, 200, 7, {}));
  const auto two = Value(FitSquashToFrame(*posterior_, Inputs(), labels_, left_, 200, 7, {}));
  const auto other = Value(FitSquashToFrame(*posterior_, Inputs(), labels_, left_, 200, 8, {}));
  EXPECT_EQ(one.a, two.a);
  EXPECT_EQ(one.b, two.b);
  EXPECT_NE(one.b, other.b);
}

}  // namespace
}  // namespace egosieve::vision
