// Matches between the features of two frames: the nearest by the distance d of descriptors, by
// OpenCV's exhaustive search, kept where
//
//   d1 < 0.8 d2         the nearest is clearly nearer than the second (Lowe, 2004)
//   mutual              each is the other's nearest
//
// Key points and corners are matched separately. Cost: 2 n m 128 multiply-adds.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/paper/feature_extractor.h"

namespace egosieve::vision {

// queryIdx is the index in `first`, trainIdx in `second`; in increasing order of queryIdx. The
// result does not depend on OpenCV's number of threads.
std::vector<cv::DMatch> MatchFeatures(const FeatureSet& first, const FeatureSet& second);

}  // namespace egosieve::vision
