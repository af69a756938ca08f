// Decides over a shot which pixels move: from the maps, the colours and the edges of all of its
// pictures at once.
//
//   u(x)     clamp(linked log odds of the map, +-kMostOfMap) + colour evidence (C3)            (SS1)
//   E(S)     sum_x -u(x) S(x)
//            + within sum_{x ~ y} exp(-|c_x - c_y|^2 / (2 m)) [S(x) != S(y)]
//            + along sum_{x -> y} k_xy [S(x) != S(y)]                                          (SS2)
//   l(x)     u(x) + d (2 S(x) - 1),   d = min(kMostDecided, mean of |u| over the shot)         (SS3)
//
// x ~ y are neighbours in a picture, c their Lab colours in pictures stretched by the shot's range of
// levels (tonal_range.h), and m the mean of |c_x - c_y|^2 over the shot. x -> y is the pixel of the picture before where flow leads, k_xy the agreement of flow with
// its return (temporal_link.h). S minimises E by maximum flow. The colours are learnt from the maps
// and once more with S: p / 2 where S is 0, (1 + p) / 2 where it is 1. The decision is no surer
// than what it rests on: of a shot that tells nothing it says nothing, and where d would be below
// kLeastDecided, S is not asked for.
//
// The graph's nodes are blocks of pixels, so that the longer side has at most kLongestSide of them.
// The result depends only on the frames given, not on the number of threads.
//
// References: Boykov & Kolmogorov (2004) for maximum flow, by OpenCV; Papazoglou & Ferrari, Fast
// object segmentation in unconstrained video (2013).
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/masks/colour_model.h"
#include "vision/masks/temporal_link.h"

namespace egosieve::vision {

// The strengths of (SS2) and the limit of (C3), log odds.
struct ShotSegmentationOptions {
  float within = 3.0f, along = 2.0f;  // not negative
  float colour_limit = 4.0f;          // positive
};

// (SS3) of each picture, of its size. log_odds: of the linked map. The first picture's flow is not
// read.
std::vector<cv::Mat1f> SegmentShot(const std::vector<LinkFrame>& frames,
                                   const ShotSegmentationOptions& options);

}  // namespace egosieve::vision
