// Scores residuals and labels of features against ground truth: movers against static points.
#pragma once

#include <opencv2/core.hpp>

#include "vision/labelling/labelled_frame.h"

namespace egosieve::vision {

// Areas under the ROC curve.
struct FeatureScore {
  double residual_auc;  // of the selected motion model
  double label_auc;
};

// mask: CV_8UC1 of the labelled frame's size; 255 mover, 128 not scored, else static.
FeatureScore ScoreAgainstMask(const LabelledFrame& frame, const cv::Mat& mask);

}  // namespace egosieve::vision
