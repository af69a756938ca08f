// Scores labels against ground truth.
#pragma once

#include <opencv2/core.hpp>

#include "vision/labelling/labelled_frame.h"

namespace egosieve::vision {

// Area under the ROC curve of the labels. mask: CV_8UC1 of the labelled frame's size; 255 mover, 128
// not scored, else static.
double AreaUnderMask(const LabelledFrame& frame, const cv::Mat& mask);

}  // namespace egosieve::vision
