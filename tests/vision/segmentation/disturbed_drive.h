// A synthetic drive with something going wrong in its middle, and how well its end is segmented.
//
// The drive is played to its middle, then come the disturbing frames, then its second half. The
// maps of the last frames, that have had time to recover, are scored against the drive's masks.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "vision/segmentation/online_segmenter.h"

namespace egosieve::vision {

struct Disturbance {
  std::string name;
  // Disturbing frame number `step`, from the drive's last picture before it.
  cv::Mat (*frame)(const cv::Mat& last, int step);
  int count = 6;                   // of the disturbing frames
  bool nothing_is_learnt = false;  // from them
  int skipped = 0;                 // of the drive's own frames, behind them
  cv::Size size_after = {};        // of the frames behind them; empty: as before
};

struct ProcessedFrame {
  SegmentationMap map;
  FrameRecord record;
};
// The frame through all steps of the segmenter.
ProcessedFrame ProcessFrame(OnlineSegmenter& segmenter, const Frame& frame);

enum class DriveProfile { kDefault, kFast };

// Area under the ROC curve of all pixels of the scored frames. Expects that every frame has a map
// of its size, and a reason where nothing was learnt from it; and that the scored frames are learnt
// from.
double AucOfTheEnd(DriveProfile profile, const Disturbance& disturbance);
// Of the drive without any, all of it of that size; empty: its own.
double UndisturbedAuc(DriveProfile profile, cv::Size size = {});

// `image` with noise of that deviation, in grey levels.
cv::Mat WithNoise(const cv::Mat& image, double deviation, uint64_t seed);

// The camera stands: the last picture with the sensor's noise; with three textured boxes that cross
// it.
cv::Mat StandingStill(const cv::Mat& last, int step);
cv::Mat StandingAmongMovers(const cv::Mat& last, int step);

}  // namespace egosieve::vision
