#include "vision/paper/fundamental_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace egosieve::vision {
namespace {

using Points = std::vector<cv::Point2f>;

constexpr double kThreshold = 0.25;  // T
constexpr size_t kFewestPairs = 7;
constexpr float kLeastWidth = 2.0F;     // pixels, of the places in an image
constexpr double kSupportPixels = 2.0;  // trust
constexpr double kLeastSupport = 0.3;

bool LieOnALine(const Points& points) {
  const cv::Size2f box = cv::minAreaRect(points).size;
  return std::min(box.width, box.height) < kLeastWidth;
}

// Empty where the points do not determine a matrix.
cv::Mat FindFundamental(const Points& first, const Points& second, uint64_t seed) {
  cv::UsacParams parameters;
  parameters.threshold = kThreshold;
  parameters.confidence = 0.9999;
  parameters.maxIterations = 2000;
  parameters.loMethod = cv::LOCAL_OPTIM_INNER_AND_ITER_LO;
  parameters.loIterations = 10;
  parameters.loSampleSize = 30;
  parameters.randomGeneratorState =
      static_cast<int>(MixSeed(seed, 0, 0) % std::numeric_limits<int>::max());
  if (LieOnALine(first) || LieOnALine(second)) return {};
  try {
    const cv::Mat matrix = cv::findFundamentalMat(first, second, cv::noArray(), parameters);
    return matrix.size() == cv::Size(3, 3) && cv::checkRange(matrix) ? matrix : cv::Mat();
  } catch (const cv::Exception&) {  // where it gives up, it throws in some versions
    return {};
  }
}

// |e| over the root of `squares`, of the norms of the lines' normals.
double Ratio(double e, double squares) {
  return squares > 0.0 ? std::abs(e) / std::sqrt(squares) : 0.0;
}

}  // namespace

double SampsonDistance(const Eigen::Matrix3d& f, const PointPair& pair) {
  const Eigen::Vector3d a(pair.x1, pair.y1, 1.0), b(pair.x2, pair.y2, 1.0);
  const Eigen::Vector3d line2 = f * a, line1 = f.transpose() * b;
  return Ratio(b.dot(line2), line1.head<2>().squaredNorm() + line2.head<2>().squaredNorm());
}

double PointToLineDistance(const Eigen::Matrix3d& f, const PointPair& pair) {
  const Eigen::Vector3d line2 = f * Eigen::Vector3d(pair.x1, pair.y1, 1.0);
  return Ratio(Eigen::Vector3d(pair.x2, pair.y2, 1.0).dot(line2), line2.head<2>().squaredNorm());
}

MotionModel FitFundamental(const std::vector<PointPair>& pairs, uint64_t seed) {
  MotionModel model;
  Points first, second;
  for (const PointPair& p : pairs) {
    if (!std::isfinite(p.x1 + p.y1 + p.x2 + p.y2)) continue;
    first.emplace_back(p.x1, p.y1);
    second.emplace_back(p.x2, p.y2);
  }
  if (first.size() < kFewestPairs) {
    model.reason = absl::StrCat("fundamental matrix: ", first.size(), " point pairs, ",
                                kFewestPairs, " are needed");
    return model;
  }
  const cv::Mat matrix = FindFundamental(first, second, seed);
  if (matrix.empty()) {
    model.reason =
        absl::StrCat("fundamental matrix: the ", first.size(), " point pairs do not determine one");
    return model;
  }
  model.kind = MotionModelKind::kFundamental;
  cv::cv2eigen(matrix, model.matrix);
  model.inlier_count = std::ranges::count_if(pairs, [&](const PointPair& pair) {
    return SampsonDistance(model.matrix, pair) < kSupportPixels;
  });
  const double support =
      static_cast<double>(model.inlier_count) / static_cast<double>(pairs.size());
  model.trusted = support >= kLeastSupport;
  if (!model.trusted) {
    model.reason = absl::StrFormat("only %.0f %% of the matches agree on one motion of the camera",
                                   100.0 * support);
  }
  return model;
}

}  // namespace egosieve::vision
