// Places of a picture that agree with the drive's fixed pattern
// (vision/own_vehicle/fixed_pattern.h): reflections, dirt on the windscreen, and the own vehicle as
// far as it is not known as such.
#ifndef EGOSIEVE_VISION_LABELLING_PATTERN_PLACES_H_
#define EGOSIEVE_VISION_LABELLING_PATTERN_PLACES_H_

#include <memory>
#include <opencv2/core.hpp>

#include "vision/own_vehicle/fixed_pattern.h"

namespace egosieve::vision {

class PatternPlaces {
 public:
  PatternPlaces() = default;  // none
  // pattern: null where none is known. grey: of the drive's size, else there are none.
  PatternPlaces(const FixedPattern* pattern, const cv::Mat& grey);

  bool empty() const { return agreeing_.empty(); }
  // place: in `grey`, pixels.
  bool Contain(cv::Point2f place) const;

 private:
  cv::Mat1b agreeing_;  // of the reduced picture
  double scale_ = 1.0;  // reduced over given
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_PATTERN_PLACES_H_
