// Writes a run's masks for another program: all checks first, then frame by frame.
#ifndef EGOSIEVE_TOOLS_MASKS_MASK_EXPORT_H_
#define EGOSIEVE_TOOLS_MASKS_MASK_EXPORT_H_

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/masks/coverage.h"
#include "tools/masks/frame_masks.h"
#include "tools/masks/mask_format.h"
#include "tools/masks/mask_writer.h"
#include "tools/masks/transforms_file.h"
#include "tools/masks/user_masks.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/drive_input.h"

namespace egosieve::tools {

struct MaskExportOptions {
  MaskFormat format = MaskFormat::kPlain;
  FrameMaskOptions mask;
  bool invert = false;
  bool overwrite = false;  // files of the same names
  std::string out;
  std::string frames;      // folder for the pictures; empty: they are not written
  std::string also;        // the user's own masks (user_masks.h)
  std::string transforms;  // of kNerfstudio (transforms_file.h)
  std::string truth;       // true masks to compare with (coverage.h)
};

class MaskExport {
 public:
  // Checks all that can be checked before the input is segmented, and writes nothing. run: the
  // folder that holds the run, or is to.
  static absl::StatusOr<MaskExport> Prepare(DriveInput input, const std::string& run,
                                            const MaskExportOptions& options);

  // after_frame: as in reconstruct_run.h.
  absl::Status Run(const RunFolder& folder, const std::vector<FrameLine>& lines,
                   const std::function<bool()>& after_frame);

  bool is_video() const { return files_.empty(); }
  int64_t images() const { return static_cast<int64_t>(masked_.size()); }
  // What is left to say, a warning each.
  const std::vector<std::string>& warnings() const { return warnings_; }
  const Coverage& coverage() const { return coverage_; }

 private:
  MaskExport(DriveInput input, const MaskExportOptions& options)
      : input_(std::move(input)),
        options_(options),
        writer_(options.format, options.out, SequenceName()) {}

  std::string SequenceName() const;
  absl::Status CheckNames(const std::vector<std::string>& images) const;
  absl::Status WriteFrame(const RunFolder& folder, const FrameLine& line);
  absl::Status WritePicture(const std::string& image, const std::string& path,
                            const cv::Mat& frame);
  absl::StatusOr<cv::Mat3b> ReadVideoFrame(const FrameLine& line);

  DriveInput input_;
  MaskExportOptions options_;
  std::vector<std::string> files_;  // of the pictures; empty for a video
  UserMasks also_;
  std::optional<TransformsFile> transforms_;
  Coverage coverage_;
  MaskWriter writer_;
  std::set<std::string> masked_;  // names of the images
  std::vector<std::string> warnings_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MASKS_MASK_EXPORT_H_
