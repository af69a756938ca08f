// Writes a run's masks for another program: first makes all checks, then works frame by frame.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/masks/frame_masks.h"
#include "tools/masks/mask_format.h"
#include "tools/masks/mask_writer.h"
#include "tools/masks/transforms_file.h"
#include "tools/masks/undistortion.h"
#include "tools/masks/user_masks.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/drive_input.h"

namespace egosieve::tools {

struct MaskExportOptions {
  MaskFormat format = MaskFormat::kPlain;
  FrameMaskOptions mask;
  bool invert = false;
  bool overwrite = false;  // replace files of the same names
  std::string out;
  std::string frames;      // folder for the pictures; empty: not written
  std::string also;        // the user's own masks (user_masks.h)
  std::string transforms;  // of kNerfstudio (transforms_file.h)
  // The video from which the pictures were taken; the run is then one of the video
  // (video_frames.h). Empty: the run is one of the pictures.
  std::string video;
  // What image_undistorter wrote, and the model that it read: masks of the undistorted pictures
  // (undistortion.h). Both or neither.
  std::string undistort, sparse;
};

class MaskExport {
 public:
  // Makes all checks that are possible before the input is segmented, and writes nothing. run: the
  // folder of the run, which need not exist yet.
  static absl::StatusOr<MaskExport> Prepare(DriveInput input, const std::string& run,
                                            const MaskExportOptions& options);

  // Finds the pictures in the video. after_frame: as in video_frames.h.
  absl::Status FindPictures(vision::FrameSource& video, const std::function<bool()>& after_frame);

  // after_frame: as in refine_run.h. An interrupted call of the same options on the same run is
  // continued. OutOfRange, before anything is written, if the format lacks a mover's number.
  absl::Status Run(const RunFolder& folder, const std::vector<FrameLine>& lines,
                   const std::function<bool()>& after_frame);

  bool is_video() const { return files_.empty(); }
  int64_t images() const { return written_; }
  // Remaining messages, one warning each.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  MaskExport(DriveInput input, const MaskExportOptions& options)
      : input_(std::move(input)),
        options_(options),
        writer_(options.format, options.out, SequenceName()) {}

  std::string SequenceName() const;
  // The picture's name, inside any folder.
  std::string ImageName(int64_t index) const {
    return NameInside(input_.frames->image_name(index));
  }
  // Checks that every file to write lies in its folder, and that no two are the same.
  absl::Status CheckTargets();
  std::vector<int> Reductions() const {
    return transforms_ ? transforms_->reductions() : std::vector<int>();
  }
  // The files of a picture.
  std::vector<std::string> Targets(int64_t index) const;
  // Checks that the format has room for the movers' numbers.
  absl::Status CheckNumbers(const RunFolder& folder,
                            const std::vector<std::pair<int64_t, FrameLine>>& chosen) const;
  // Whether an interrupted export has made the picture's files.
  bool IsWritten(int64_t index) const;
  // Notes in --out what is being made, and whether that was begun before.
  absl::Status Mark(const RunFolder& folder);
  // Writes the mask of the run's frame `line` for picture `index` of the input.
  absl::Status WriteFrame(const RunFolder& folder, const FrameLine& line, int64_t index);
  // Pictures in the order of their masks, each with the line of its frame.
  absl::StatusOr<std::vector<std::pair<int64_t, FrameLine>>> Chosen(
      const std::vector<FrameLine>& lines) const;
  absl::Status WritePicture(const std::string& image, const std::string& path,
                            const cv::Mat& frame);
  // The input's picture, turned upright; a single pixel if it cannot be read.
  absl::StatusOr<cv::Mat3b> ReadShown(int64_t index);

  DriveInput input_;
  MaskExportOptions options_;
  std::vector<std::string> files_;  // of the pictures; empty for a video
  std::vector<int64_t> frames_;     // of the video, one per picture; empty without a video
  UserMasks also_;
  std::optional<TransformsFile> transforms_;
  std::optional<Undistortion> undistortion_;
  MaskWriter writer_;
  std::set<std::string> target_folders_;
  bool continues_ = false;
  int64_t written_ = 0;
  std::vector<std::string> warnings_;
};

}  // namespace egosieve::tools
