// Pictures for the first pass over a drive: pairs for the camera's motion, and windows for its
// focal length.
//
// Pairs are about 0.08 s long. In a drive that is too short for as many as travel_prior.h needs they
// share pictures. Windows (window_tracks.h) are spread over the drive and do not overlap.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/frame/equalization.h"
#include "vision/frame/frame_source.h"
#include "vision/geometry/lens_correction.h"
#include "vision/geometry/point_pair.h"
#include "vision/labelling/window_tracks.h"
#include "vision/trajectory/bundle_adjustment.h"

namespace egosieve::vision {

// Length of the part of a drive that is read.
inline constexpr int64_t kLongestDriveFrames = 3000;

struct PicturePair {
  std::array<double, 2> times;       // seconds
  std::array<cv::Mat1b, 2> reduced;  // fixed_pattern.h, not equalised
  std::vector<PointPair> links;      // between textured places, pixels of the original pictures

  double seconds() const { return times[0]; }
  double length_seconds() const { return times[1] - times[0]; }
};

struct DrivePictures {
  cv::Size size;  // of the original pictures; pictures of another size are left out
  std::vector<PicturePair> pairs;
  std::vector<TrackWindow> windows;  // pixels of the original pictures
};

struct DrivePicturesOptions {
  int windows = kMostWindows;  // at most; not negative
  int64_t first_frame = 0;     // of the drive in the input
  int64_t end_frame = -1;      // index after its last frame; -1: the end of the input
  cv::Mat1b ignored;           // ignored_area.h: never part of the static scene
  // Not null: pictures are corrected, and all places are those of the corrected ones. `ignored` is
  // of the pictures as they are read.
  std::shared_ptr<const LensCorrection> lens;
  Equalization equalization = Equalization::kNone;
};

// Reads from `source`, forwards only. Unreadable frames are skipped; errors are the source's.
absl::StatusOr<DrivePictures> ReadDrivePictures(FrameSource& source,
                                                const DrivePicturesOptions& options);

}  // namespace egosieve::vision
