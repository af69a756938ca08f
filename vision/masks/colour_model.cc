#include "vision/masks/colour_model.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <opencv2/ml.hpp>

#include "absl/strings/str_format.h"
#include "kernels/base/parallel_for.h"

namespace egosieve::vision {
namespace {

constexpr int kParts = 5;
constexpr double kSpread = 8.0;  // squared steps of Lab
constexpr float kFar = 0.02f;
constexpr int kSamples = 4000;
constexpr int kIterations = 30;
constexpr uint64_t kSeed = 1;  // of the first means

double Sum(const std::vector<cv::Mat1f>& weights) {
  double sum = 0.0;
  for (const cv::Mat1f& of_picture : weights) sum += cv::sum(of_picture)[0];
  return sum;
}

// kSamples colours, each as often as its weight says: those at evenly spaced steps of the running
// sum of the weights. `sum` must be positive.
cv::Mat1f Sample(const std::vector<cv::Mat3b>& colours, const std::vector<cv::Mat1f>& weights,
                 double sum) {
  cv::Mat1f samples(kSamples, 3);
  double running = 0.0;
  int taken = 0;
  for (size_t t = 0; t < colours.size(); ++t) {
    for (int y = 0; y < colours[t].rows; ++y) {
      for (int x = 0; x < colours[t].cols; ++x) {
        running += weights[t](y, x);
        for (; taken < kSamples && (taken + 0.5) / kSamples * sum <= running; ++taken) {
          for (int k = 0; k < 3; ++k) samples(taken, k) = colours[t](y, x)[k];
        }
      }
    }
  }
  return samples.rowRange(0, taken);
}

class Mixture {
 public:
  explicit Mixture(const cv::Mat1f& samples) {
    const auto em = cv::ml::EM::create();
    em->setClustersNumber(kParts);
    em->setCovarianceMatrixType(cv::ml::EM::COV_MAT_GENERIC);
    em->setTermCriteria({cv::TermCriteria::COUNT + cv::TermCriteria::EPS, kIterations, 1e-3});
    cv::theRNG().state = kSeed;
    em->trainEM(samples);
    const cv::Mat1d weights = em->getWeights(), means = em->getMeans();
    std::vector<cv::Mat> covariances;
    em->getCovs(covariances);
    for (int k = 0; k < means.rows; ++k) {
      Eigen::Matrix3d covariance;
      for (int i = 0; i < 9; ++i) {
        covariance(i / 3, i % 3) = cv::Mat1d(covariances[k])(i / 3, i % 3);
      }
      covariance.diagonal().array() += kSpread;
      const Eigen::Matrix3d lower = covariance.llt().matrixL();
      const Eigen::Matrix3d whiten =
          lower.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity());
      const Eigen::Vector3d mean(means(k, 0), means(k, 1), means(k, 2));
      const double log_scale = std::log(std::max(weights(k), 1e-12)) -
                               1.5 * std::log(2.0 * std::numbers::pi) -
                               std::log(lower.diagonal().prod());
      parts_.push_back(
          {whiten.cast<float>(), (whiten * mean).cast<float>(), static_cast<float>(log_scale)});
    }
  }

  float LogDensity(const cv::Vec3b& colour) const {
    const Eigen::Vector3f c(colour[0], colour[1], colour[2]);
    std::array<float, kParts> logs;
    float top = -1e30f;
    for (size_t k = 0; k < parts_.size(); ++k) {
      const Part& part = parts_[k];
      logs[k] = part.log_scale - 0.5f * (part.whiten * c - part.mean).squaredNorm();
      top = std::max(top, logs[k]);
    }
    float sum = 0.0f;
    for (size_t k = 0; k < parts_.size(); ++k) sum += std::exp(logs[k] - top);
    return top + std::log(sum);
  }

 private:
  struct Part {
    Eigen::Matrix3f whiten;
    Eigen::Vector3f mean;  // whitened
    float log_scale;
  };
  std::vector<Part> parts_;
};

}  // namespace

absl::Status ColourModelOptions::Validate() const {
  if (around > 0.0 && support_pixels > 0.0 && limit > 0.0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("around = %g, support_pixels = %g, limit = %g; all must be positive", around,
                      support_pixels, limit));
}

std::vector<cv::Mat1f> ColourEvidence(const std::vector<cv::Mat3b>& images,
                                      const std::vector<cv::Mat1f>& probability,
                                      const ColourModelOptions& options) {
  const auto count = static_cast<int64_t>(images.size());
  std::vector<cv::Mat3b> colours(count);
  std::vector<cv::Mat1f> moving(count), still(count), around(count);
  kernels::ParallelFor(count, [&](int64_t t) {
    cv::cvtColor(images[t], colours[t], cv::COLOR_BGR2Lab);
    const cv::Mat1f &p = probability[t], q = 1.0f - p;
    moving[t] = p.mul(p).mul(p);
    still[t] = q.mul(q).mul(q);
    cv::Mat1f near;
    cv::GaussianBlur(p, near, {}, options.around * std::max(p.cols, p.rows));
    double most = 0.0;
    cv::minMaxLoc(near, nullptr, &most);
    around[t] = still[t].mul(near + kFar * static_cast<float>(most));
  });
  const double all_moving = Sum(moving), all_still = Sum(still),
               least = std::min(all_moving, all_still);
  const auto known = static_cast<float>(least / (least + options.support_pixels));
  const auto limit = static_cast<float>(options.limit);
  std::vector<cv::Mat1f> evidence(count);
  for (int64_t t = 0; t < count; ++t) evidence[t] = cv::Mat1f::zeros(images[t].size());
  const double all_around = Sum(around);
  if (!(least > 0.0) || !(all_around > 0.0)) return evidence;
  const Mixture of_moving(Sample(colours, moving, all_moving));
  const Mixture of_still(Sample(colours, around, all_around));
  kernels::ParallelFor(count, [&](int64_t t) {
    std::transform(colours[t].begin(), colours[t].end(), evidence[t].begin(),
                   [&](const cv::Vec3b& colour) {
                     const float ratio = of_moving.LogDensity(colour) - of_still.LogDensity(colour);
                     return std::clamp(known * ratio, -limit, limit);
                   });
  });
  return evidence;
}

}  // namespace egosieve::vision
