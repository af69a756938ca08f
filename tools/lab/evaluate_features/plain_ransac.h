// A baseline of a few lines over OpenCV: the distance that every labeller here has to surpass.
//
//   SIFT key points, nearest by L2, d1 < 0.8 d2, fundamental matrix by RANSAC at 1 pixel,
//   Sampson's distance
#ifndef EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_PLAIN_RANSAC_H_
#define EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_PLAIN_RANSAC_H_

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::tools {

struct PlainRansac {
  std::vector<vision::PointPair> pairs;  // the matches
  Eigen::Matrix3d fundamental = Eigen::Matrix3d::Zero();
};

// BGR images. FailedPrecondition if there are too few matches.
absl::StatusOr<PlainRansac> EstimateByPlainRansac(const cv::Mat& first, const cv::Mat& second);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_PLAIN_RANSAC_H_
