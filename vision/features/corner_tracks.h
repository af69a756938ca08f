// Corners followed through the pictures of a short window to a fraction of a pixel.
//
// 1. Corners (corner_detector.h) of the first picture, spread evenly over it.
// 2. Pyramidal Lucas-Kanade from each picture to the next, and back. A track ends where it does not
//    return to within 0.3 pixels, or comes close to the picture's border.
//
// Reference: Bouguet (2001), pyramidal implementation of the tracker of Lucas & Kanade.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

// Positions in consecutive pictures of the window, from the first picture on, pixels.
using CornerTrack = std::vector<cv::Point2f>;

class CornerTracker {
 public:
  static constexpr int kMostCorners = 300;

  // corners: the largest number taken from the first picture; positive.
  explicit CornerTracker(int corners = kMostCorners) : corners_(corners) {}

  // The tracker that has the given tracks after `pictures` pictures. SetLastPicture() must give the
  // last of them before the next one is added.
  static CornerTracker Of(std::vector<CornerTrack> tracks, int pictures);

  // Adds the next picture, CV_8UC1; all pictures must have one size.
  void Add(const cv::Mat& picture);
  void SetLastPicture(const cv::Mat& picture);

  // The tracks of the first picture's corners, row by row, each as long as the corner was followed.
  const std::vector<CornerTrack>& tracks() const { return tracks_; }
  int pictures() const { return pictures_; }
  // Whether no track reaches the last picture.
  bool IsLost() const { return alive_.empty(); }
  // Median distance, in pixels, between a corner's positions in the first and in the last picture,
  // over the tracks that reach the last one; 0 where none does.
  double MedianMotion() const;

 private:
  int corners_;
  int pictures_ = 0;
  std::vector<CornerTrack> tracks_;
  std::vector<size_t> alive_;     // indices into tracks_
  std::vector<cv::Mat> pyramid_;  // of the last picture
};

}  // namespace egosieve::vision
