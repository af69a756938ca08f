// Corners followed through the pictures of a short window to a fraction of a pixel.
//
// 1. Corners (corner_detector.h) of the first picture, spread evenly over it (spread.h).
// 2. Pyramidal Lucas-Kanade from each picture to the next, and back. A track ends where it does not
//    come back to within 0.3 pixels, or comes near the picture's border.
//
// `corners` tracks begin; those that are seen in fewer than `least_pictures` are left out.
//
// Reference: Bouguet (2001), pyramidal implementation of the tracker of Lucas & Kanade.
#ifndef EGOSIEVE_VISION_FEATURES_CORNER_TRACKS_H_
#define EGOSIEVE_VISION_FEATURES_CORNER_TRACKS_H_

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

struct CornerTrackOptions {
  int corners = 300;       // of the first picture, at most; positive
  int least_pictures = 3;  // at least 2
};

// Places in the first pictures of the window, pixels; at least least_pictures of them.
using CornerTrack = std::vector<cv::Point2f>;

// pictures: CV_8UC1, all of one size. Row by row of the first picture.
std::vector<CornerTrack> TrackCorners(const std::vector<cv::Mat>& pictures,
                                      const CornerTrackOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FEATURES_CORNER_TRACKS_H_
