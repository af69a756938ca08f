// The camera of a run: estimated in a first pass over the drive and stored in the run folder, from
// which a resumed run reads it; or learnt on the way and stored at the run's end.
//
// shots.json: ShotList. The files of later shots are shots/NNNNNN.camera.json, ..., by their first
// frame.
//
// camera.json:
//   focal_pixels, width, height    pixels; with what else lens_file.h tells of a lens with distortion
//   log_focal_deviation            deviation of the focal length's logarithm
//   pairs                          of pictures, for the direction of travel and the own vehicle
//   own_vehicle_share              of the image
//   fixed_pattern, windscreen      whether fixed_pattern.png and windscreen.png exist
//   travel_direction, travel_concentration, travel_share      vision/trajectory/travel_prior.h
// own_vehicle.png, if present: 255 own vehicle, 0 scene.
// fixed_pattern.png, if present: the median of pictures of the drive.
// windscreen.png, if present: 255 where objects on the windscreen mix with the scene.
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/segment/lens_file.h"
#include "vision/labelling/drive_camera.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::tools {

struct RunCamera {
  LensFile lens;
  vision::TravelPrior travel;
  int pair_count = 0;       // of pictures, from which it is
  cv::Mat1b own_vehicle;    // 255 on the own vehicle; empty: none
  cv::Mat1b windscreen;     // likewise
  cv::Mat1b fixed_pattern;  // vision/own_vehicle/fixed_pattern.h; empty: not known
  std::string text;         // of camera.json
};

// One for each shot, by its first frame; 0 for the first.
struct RunCameras {
  std::map<int64_t, RunCamera> shots;
  int64_t end = -1;  // shots were looked for before this frame; -1: in all frames
};

// size: of the frames. Images of another size are left out. lens: if it has distortion; else null.
absl::StatusOr<RunCamera> MakeRunCamera(const vision::DriveCamera& camera, cv::Size size,
                                        const LensFile* lens = nullptr);

// The cameras of the run in `directory`; without shots if it has none. DataLoss for a damaged file.
absl::StatusOr<RunCameras> ReadRunCameras(const std::string& directory);

absl::Status WriteRunCameras(const std::string& directory, const RunCameras& cameras);

}  // namespace egosieve::tools
