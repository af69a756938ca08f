// Objects of a probability map: connected regions of likely motion, nearly certain at some pixel.
//
//   object = region of 8-connected pixels with p >= low that holds a pixel with p >= high    (OB1)
//
// A single threshold either splits movers or finds objects in noise. A patch of middling
// probability is mostly a mislabelled part of the static scene; yet the rim and the textureless
// parts of a mover have no higher probability either. Reference: Canny (1986), thresholding with
// hysteresis.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"

namespace egosieve::vision {

struct ObjectThresholds {
  double low = 0.25;  // in [0, high]
  double high = 0.8;  // in [low, 1]

  absl::Status Validate() const;
};

// (OB1) for masks, CV_8UC1 of one size, non-zero where p >= low and where p >= high. 0: no object.
// Objects are numbered from 1 in the order of their first pixels, row by row.
cv::Mat1i NumberObjects(const cv::Mat1b& above_low, const cv::Mat1b& above_high);

struct MapObject {
  cv::Rect box;  // pixels of the map
  int64_t pixels = 0;
  double peak = 0.0;  // of its probabilities
  double mean = 0.0;  // likewise
  double sure = 0.0;  // 1 - 2 mean sqrt(p (1 - p)): 1 where all p are 0 or 1, 0 where all are 1/2
};

// In the order of their numbers.
std::vector<MapObject> FindObjects(const cv::Mat1f& probability,
                                   const ObjectThresholds& thresholds);

}  // namespace egosieve::vision
