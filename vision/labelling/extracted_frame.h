// The data computed once from a single frame.
#ifndef EGOSIEVE_VISION_LABELLING_EXTRACTED_FRAME_H_
#define EGOSIEVE_VISION_LABELLING_EXTRACTED_FRAME_H_

#include <mutex>
#include <opencv2/core.hpp>

#include "absl/status/statusor.h"
#include "vision/features/feature_extractor.h"
#include "vision/frame/frame.h"
#include "vision/labelling/stopwatch.h"

namespace egosieve::vision {

// Shared by pointer and immutable to its users. Features may be computed only when first needed;
// the result is the same.
struct ExtractedFrame {
  Frame frame;
  cv::Mat grey;  // CV_8UC1, equalised
  FeatureOptions feature_options;
  double equalization_milliseconds = 0.0;

  // Thread-safe.
  const absl::StatusOr<FeatureSet>& features() const {
    std::call_once(once_, [this] {
      Stopwatch watch;
      features_ = ExtractFeatures(grey, feature_options);
      features_milliseconds_ = watch.LapMilliseconds();
    });
    return features_;
  }

  // Duration of the first call of features(); valid only after that call.
  double features_milliseconds() const { return features_milliseconds_; }

 private:
  mutable std::once_flag once_;
  mutable double features_milliseconds_ = 0.0;
  mutable absl::StatusOr<FeatureSet> features_ = absl::UnknownError("not computed");
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_EXTRACTED_FRAME_H_
