// Tracks of corners through one window of pictures, from which the focal length is learnt
// (bundle_adjustment.h).
//
// A window lasts at least 0.6 s, until the points have moved by a fortieth of the pictures' longer
// side, and at most 2 s or 37 pictures. Five of its pictures are kept besides the first, evenly
// spread over it.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/features/corner_tracks.h"
#include "vision/trajectory/bundle_adjustment.h"

namespace egosieve::vision {

// Longer side, in pixels, to which the pictures are reduced.
inline constexpr int kLongestDriveSide = 1280;
inline constexpr int kLongestWindow = 36;  // pictures after the first
inline constexpr int kKeptPictures = 6;    // at most
inline constexpr int kMostWindows = 8;     // of a drive

// Positions of corners in the pictures kept of a window, pixels of the reduced pictures. As in
// TrackWindow.
struct KeptTracks {
  int pictures = 0;
  std::vector<CornerTrack> tracks;
};

class WindowTracks {
 public:
  // Adds the next picture: CV_8UC1, equalised, reduced to kLongestDriveSide. All pictures must have
  // one size.
  void Add(const cv::Mat& grey, double seconds);

  // The same window after Tracks() and start_seconds() were kept, without the last picture, which
  // SetLastPicture() then gives.
  static WindowTracks Of(const KeptTracks& tracks, double start_seconds);
  void SetLastPicture(const cv::Mat& grey) { tracker_.SetLastPicture(grey); }

  int pictures() const { return tracker_.pictures(); }
  double start_seconds() const { return start_seconds_; }
  // After Add(): whether the window is as long as it should be.
  bool IsLongEnough() const { return is_long_enough_; }
  bool HasMoved() const;
  // Whether no corner was followed up to the last picture.
  bool IsLost() const { return tracker_.IsLost(); }

  // All positions in all pictures.
  KeptTracks Tracks() const { return {tracker_.pictures(), tracker_.tracks()}; }
  // The tracks that reach at least three of the kept pictures and do not begin in an ignored place.
  // ignored: ignored_area.h, of the size of the reduced pictures. No pictures if fewer than three
  // were added.
  KeptTracks Kept(const cv::Mat1b& ignored) const;

 private:
  CornerTracker tracker_;
  cv::Size size_;
  double start_seconds_ = 0.0;
  bool is_long_enough_ = false;
};

// In pixels of the original pictures. reduced, full: sizes of the pictures.
TrackWindow EnlargeTracks(const KeptTracks& kept, cv::Size reduced, cv::Size full);

}  // namespace egosieve::vision
