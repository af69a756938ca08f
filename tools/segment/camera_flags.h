// What `segment` is given, or finds out, of the camera: its lens, and which part of its image is
// not the world. --camera, --ignore.
#ifndef EGOSIEVE_TOOLS_SEGMENT_CAMERA_FLAGS_H_
#define EGOSIEVE_TOOLS_SEGMENT_CAMERA_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "tools/segment/drive_input.h"
#include "tools/segment/run_camera.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::tools {

class CameraFlags {
 public:
  void AddFlags(CLI::App& app);

  // Reads the files that were given. InvalidArgument for a mask or a lens that does not fit the
  // frames.
  absl::Status Read(const DriveInput& input);
  // Sets the labeller's focal_ratio and ignored area: what was given, else what the run in
  // `directory` has, where that is to go on (`resumes`), else that of a first pass from frame
  // `from` on. There is no first pass where the labeller makes nothing of it.
  absl::Status Find(const DriveInput& input, int64_t from, bool resumes,
                    const std::string& directory, vision::FrameLabellerOptions& labeller);
  // Into a run's description: flags that shape its output.
  void Describe(std::map<std::string, std::string>& flags) const;
  // Into a run folder.
  absl::Status Write(const std::string& directory) const;

 private:
  std::string camera_path_, ignore_path_;
  bool finds_own_vehicle_ = true;
  double given_ratio_ = 0.0;         // of --camera
  cv::Mat1b ignored_;                // of --ignore
  std::optional<RunCamera> camera_;  // of the first pass
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_CAMERA_FLAGS_H_
