// Corners followed through the pictures of a short window to a fraction of a pixel.
//
// 1. Corners (corner_detector.h) of the first picture, spread evenly over it (spread.h).
// 2. Pyramidal Lucas-Kanade from each picture to the next, and back. A track ends where it does not
//    come back to within 0.3 pixels, or comes near the picture's border.
//
// Reference: Bouguet (2001), pyramidal implementation of the tracker of Lucas & Kanade.
#ifndef EGOSIEVE_VISION_FEATURES_CORNER_TRACKS_H_
#define EGOSIEVE_VISION_FEATURES_CORNER_TRACKS_H_

#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

// Places in the first pictures of the window, pixels.
using CornerTrack = std::vector<cv::Point2f>;

class CornerTracker {
 public:
  // corners: of the first picture, at most; positive.
  explicit CornerTracker(int corners = 300) : corners_(corners) {}

  // The next picture, CV_8UC1, all of one size.
  void Add(const cv::Mat& picture);

  // Those of the first picture, row by row; each holds the pictures in which it was seen.
  const std::vector<CornerTrack>& tracks() const { return tracks_; }
  int pictures() const { return pictures_; }
  // Median distance from the first picture to the last one, pixels, of the tracks that reach it; 0
  // where none does.
  double MedianMotion() const;

 private:
  int corners_;
  int pictures_ = 0;
  std::vector<CornerTrack> tracks_;
  std::vector<size_t> alive_;     // of tracks_
  std::vector<cv::Mat> pyramid_;  // of the last picture
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FEATURES_CORNER_TRACKS_H_
