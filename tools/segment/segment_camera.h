// The camera of `segment`, given or estimated: its lens, and the area of its image that does not
// show the scene.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "tools/cli/progress.h"
#include "tools/segment/drive_input.h"
#include "tools/segment/lens_file.h"
#include "tools/segment/run_camera.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/drive_camera.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::tools {

struct CameraSettings {
  std::string lens, ignore;  // files; empty: none
  bool finds_own_vehicle = true, has_first_pass = true;
};

class SegmentCamera {
 public:
  // Reads the given files. InvalidArgument if a mask or a lens does not fit the frames.
  absl::Status Read(const CameraSettings& settings, const DriveInput& input);
  // Sets the labeller's focal_ratio, lens and ignored area, and later_shots. Values that were given come
  // first, then those of the run in `directory` if it is continued (`resumes`), then those of a first
  // pass from frame `from` on, with the shots before frame `end` at least; -1: all. There is no first
  // pass if the labeller does not use its results, nor for a stream and without has_first_pass: the
  // labeller then learns the focal length.
  absl::Status Find(const DriveInput& input, int64_t from, int64_t end, bool resumes,
                    const std::string& directory, const ProgressFlag& shown,
                    vision::FrameLabellerOptions& labeller);
  // Completes a run's description by what was found: the origin of the focal length, and the
  // content of --ignore.
  void Describe(std::map<std::string, std::string>& flags) const;
  // Writes the camera's files into a run folder.
  absl::Status Write(const std::string& directory) const;
  // At the run's end: what was learnt on the way, if anything was.
  absl::Status WriteLearnt(const std::string& directory, const DriveInput& input,
                           const vision::LearntCamera& learnt) const;

 private:
  struct UsedLens {
    double ratio = 0.0;            // of the pinhole pictures
    std::optional<LensFile> file;  // if the frames are no pinhole pictures
    std::shared_ptr<const vision::LensCorrection> correction;  // of `file`
  };
  // InvalidArgument if the lens cannot be corrected.
  static absl::StatusOr<UsedLens> UseLens(const LensFile& file, cv::Size frames);
  // The first pass: adds the cameras of the shots that are not known. A shot too short to tell a
  // direction of travel has the camera of the whole input, if that is a vehicle's.
  absl::Status Learn(const DriveInput& input, int64_t from, int64_t end, const ProgressFlag& shown,
                     const vision::FrameLabellerOptions& labeller);
  absl::StatusOr<RunCamera> LearnShot(vision::FrameSource& source,
                                      vision::DriveCameraOptions options, cv::Size frames) const;
  absl::Status SetCamera(const RunCamera& camera, cv::Size frames,
                         vision::FrameLabellerOptions& labeller) const;

  CameraSettings settings_;
  UsedLens given_;               // by --camera
  bool is_ratio_given_ = false;  // by --camera or as focal_ratio
  bool learns_ = false;          // the focal length, on the way
  cv::Mat1b ignored_;            // of --ignore
  RunCameras cameras_;           // of the first pass
};

}  // namespace egosieve::tools
