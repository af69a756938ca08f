// The output folder of a drive: where everything lies, and how it is written and read.
//
//   run.json                       RunDescription
//   frames.jsonl                   a FrameLine a line, in the order of the frames
//   grid/NNNNNN.{prob,std}.png     maps at grid resolution (map_image.h)
//   full/NNNNNN.{prob,std,class}.png   the same at the frames' resolution
//   render/NNNNNN.png              overlays
//   model/                         checkpoints
//   steps/NNNNNN.npz               what the frame did to the model, where maps are made later
//   report.html, overlay.mp4, eval.json, eval.csv, further.json, plots/
//
// NNNNNN is the frame's index in the input, from 0. A frame's maps are written before its line: a
// frame that has a line has its maps, whole.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_RUN_FOLDER_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_RUN_FOLDER_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_description.h"

namespace egosieve::tools {

struct FrameMaps {
  cv::Mat1f probability;
  cv::Mat1f deviation;
};

// The folder's absolute path, the same however it is written.
std::string AbsolutePath(const std::string& path);

// The grid of a frame's maps: the run's, but for the frame's own size.
kernels::ImageGrid GridOf(const FrameLine& line, const RunDescription& description);

class RunFolder {
 public:
  // Makes the folder and its parents. A folder that holds something is refused (AlreadyExists)
  // unless `overwrite` is set and it is a run folder: then a former run's files are removed, and
  // only those. Nothing is removed after an error. What a kill leaves before the first run.json
  // counts as nothing.
  static absl::StatusOr<RunFolder> Create(const std::string& path, bool overwrite);
  // NotFound where there is no folder, or no run in it.
  static absl::StatusOr<RunFolder> Open(const std::string& path);

  const std::string& path() const { return path_; }
  // path/name
  std::string File(const std::string& name) const;
  // path/folder/NNNNNNsuffix
  std::string FrameFile(const std::string& folder, int64_t index, const std::string& suffix) const;

  absl::Status WriteDescription(const RunDescription& description) const;
  absl::StatusOr<RunDescription> ReadDescription() const;

  // A last line that a crash cut short is left out; any other damage is DataLoss, with the line's
  // number. Indices increase.
  absl::StatusOr<std::vector<FrameLine>> ReadLines() const;
  absl::StatusOr<LineLog> OpenLog() const { return LineLog::Open(File("frames.jsonl")); }

  // Writes grid/NNNNNN.{prob,std}.png and returns how many deviations saturated. An empty deviation
  // (means only) is not written.
  absl::StatusOr<int64_t> WriteGridMaps(int64_t index, const FrameMaps& maps,
                                        double deviation_full_scale) const;
  // The maps of a line that has them. The deviation is left empty where `with_deviation` is
  // not set.
  absl::StatusOr<FrameMaps> ReadGridMaps(const FrameLine& line, const RunDescription& description,
                                         bool with_deviation) const;

 private:
  explicit RunFolder(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_RUN_FOLDER_H_
