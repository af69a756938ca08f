// Learns the focal length and a vehicle's direction of travel while frames arrive, for cameras
// without a first pass (drive_camera.h).
//
//   1. tracks of corners through windows of pictures               window_tracks.h
//   2. the focal length of all windows so far, after windows
//      1, 2, 4 and 8                                               bundle_adjustment.h
//
// and the direction of travel from those of pairs of pictures, after 8, 16, 32 and 64 of them
// (travel_prior.h). They are a tenth of a second apart at first, and later a sixteenth of the time
// that has passed, so they are spread over about a minute. A camera that a person carries has no
// direction of travel here.
//
// A window in which the camera has hardly moved tells nothing: it is dropped, and as many pictures
// as it had pass before the next one begins. One whose corners are all lost begins again at once. A
// window that begins at picture s is followed by one at picture 2 s or as soon as it ends,
// whichever is later: so the windows are spread over the drive, 8 of them over a minute or two.
// Then the learner needs no more pictures. Where none of them shows one rigid scene, 8 others
// follow, spread likewise: the cost per picture vanishes.
//
// Pictures of another size begin anew, too; the focal length over the longer side remains until
// they give another. A lens that zooms is not followed.
//
// State, as bytes: up to 7 windows of at most 17 KB each, and the window under way, at most 91 KB.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/frame/equalization.h"
#include "vision/frame/frame.h"
#include "vision/labelling/window_tracks.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {

struct LearntCamera {
  double focal_ratio = 0.0;          // over the longer side; 0: not known
  double log_focal_deviation = 0.0;  // standard deviation of its logarithm
  TravelPrior travel;                // not known unless of a vehicle
};

struct FocalLearnerState {
  LearntCamera learnt;
  std::vector<Eigen::Vector3d> directions;  // unit vectors
  // Of the first direction, and from when on the next may be added.
  double first_seconds = 0.0, next_seconds = 0.0;
  cv::Size size;             // of the pictures
  int64_t last_index = -1;   // of the last frame
  int64_t pictures = 0;      // since the beginning
  int64_t window_start = 0;  // number of the last window's first picture
  int64_t next_start = 0;    // number of the picture at which the next window may begin
  bool has_ended = false;
  std::vector<KeptTracks> windows;  // complete ones
  double start_seconds = 0.0;       // of the window under way
  KeptTracks under_way;             // all its pictures; none between windows
};

class FocalLearner {
 public:
  // ignored: ignored_area.h, of the size of the frames.
  FocalLearner(const cv::Mat1b& ignored, Equalization equalization)
      : ignored_(ignored), equalization_(equalization) {}

  // Takes the next frame; indices grow. grey: its equalised picture of any size. Returns whether
  // what is learnt has changed.
  bool Add(const Frame& frame, const cv::Mat& grey);
  // The direction of travel of a pair of pictures, as in travel_prior.h; seconds: of its later
  // picture. Returns whether what is learnt has changed.
  bool AddDirection(const Eigen::Vector3d& direction, double seconds);
  // For a frame that repeats the picture before.
  void Repeat(int64_t index) { state_.last_index = index; }
  // The next frame shows another scene than the one before.
  void EndScene();

  const LearntCamera& learnt() const { return state_.learnt; }

  FocalLearnerState state() const;
  // Prime() must then be given the last frame before the next Add(); otherwise the window under way
  // is dropped.
  void Restore(FocalLearnerState state);
  void Prime(const Frame& frame, const cv::Mat& grey);

 private:
  // The picture that is tracked.
  cv::Mat Picture(const Frame& frame, const cv::Mat& grey) const;
  bool EndWindow();
  bool Adjust();

  cv::Mat1b ignored_;
  Equalization equalization_;
  FocalLearnerState state_;  // without start_seconds and under_way
  WindowTracks window_;
  bool lacks_picture_ = false;  // window_ does, since Restore()
};

}  // namespace egosieve::vision
