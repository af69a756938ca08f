// Places of a picture that agree with the drive's fixed pattern
// (vision/own_vehicle/fixed_pattern.h): reflections, dirt on the windscreen, and parts of the own
// vehicle that were not found as such.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "vision/own_vehicle/fixed_pattern.h"

namespace egosieve::vision {

class PatternPlaces {
 public:
  PatternPlaces() = default;  // none
  // pattern: null if not known. grey: if it is not of the drive's size, no place agrees.
  PatternPlaces(const FixedPattern* pattern, const cv::Mat& grey);

  bool empty() const { return agreeing_.empty(); }
  // place: in `grey`, pixels.
  bool Contain(cv::Point2f place) const;

 private:
  cv::Mat1b agreeing_;  // of the reduced picture
  double scale_ = 1.0;  // reduced over given
};

}  // namespace egosieve::vision
