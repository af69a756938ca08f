// The output folder of a drive: its files, and how they are written and read.
//
//   run.json                       RunDescription
//   frames.jsonl                   one FrameLine per line, in the frames' order: segment's log
//   log/TIME-HOST-PID.jsonl        lines of maps that merge took over. Readers
//                                  merge the logs
//   grid/NNNNNN.{prob,std}.png     maps at grid resolution (map_image.h)
//   masks/, ids/, tracks.csv, full/    made by refine (tools/refine/frame_products.h);
//   reconstruct.json                   its progress
//   camera.json, own_vehicle.png, fixed_pattern.png, windscreen.png
//                                  results of the first pass (tools/segment/run_camera.h)
//   shots.json, shots/NNNNNN.{camera.json,own_vehicle.png,...}
//                                  the shots, and the same files of each later shot
//   ignored.png                    the user's own mask of areas that do not show the scene
//   frames/NNNNNN.png              pictures of a stream (segment --record)
//   render/NNNNNN.png              overlays
//   model/                         checkpoints
//   report.html, overlay.mp4, eval.json, eval.csv, further.json, plots/
//   preview.png                    the newest frame's overlay while `run` goes on
//
// NNNNNN is the frame's index in the input, from 0. A frame's maps are written before its line, so
// a frame with a line has complete maps. One program writes a run at a time (folder_lock.h).
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/line_log.h"
#include "tools/run_folder/run_description.h"
#include "tools/run_folder/shot_list.h"

namespace egosieve::tools {

struct FrameMaps {
  cv::Mat1f probability;
  cv::Mat1f deviation;
};

// A file of a frame's maps: folder/NNNNNNsuffix.
struct MapFile {
  const char* folder;
  const char* suffix;
};
// The files of a frame's maps. The probability is last, because it marks the maps as complete.
inline constexpr MapFile kMapFiles[] = {{"grid", ".std.png"}, {"grid", ".prob.png"}};

// The folder's absolute path, the same for all its spellings.
std::string AbsolutePath(const std::string& path);

// The grid of a frame's maps: the run's, but with the frame's own size.
vision::ImageGrid GridOf(const FrameLine& line, const RunDescription& description);

// The areas that do not show the scene.
class IgnoredAreas {
 public:
  // area: of the frames from `first_frame` on; 255 there, else 0; may be empty.
  void Add(int64_t first_frame, const cv::Mat1b& area) { areas_[first_frame] = area; }
  // Of the frame's size.
  cv::Mat1b In(const FrameLine& line) const;

 private:
  std::map<int64_t, cv::Mat1b> areas_;
};

class RunFolder {
 public:
  static constexpr char kOwnVehicle[] = "own_vehicle.png", kIgnored[] = "ignored.png",
                        kFixedPattern[] = "fixed_pattern.png", kWindscreen[] = "windscreen.png",
                        kRecorded[] = "frames", kDescription[] = "run.json";

  // The lock of FolderLock::Take on a folder that Create or Open will accept, made if there is
  // none. None for a folder that Create refuses: no lock file is made in another's folder.
  static absl::StatusOr<std::optional<FolderLock>> TakeOrMake(const std::string& path);
  // Makes the folder and its parents. AlreadyExists if the folder is not empty, unless `overwrite`
  // is set and it is a run folder that no other program uses (folder_lock.h). Then the files of the
  // former run are removed, and only those (former_run.h); all other files are listed on stderr.
  // Files that a killed run left before its first run.json do not count.
  static absl::StatusOr<RunFolder> Create(const std::string& path, bool overwrite);
  // NotFound if there is no folder, or no run in it.
  static absl::StatusOr<RunFolder> Open(const std::string& path);

  const std::string& path() const { return path_; }
  // path/name
  std::string File(const std::string& name) const;
  // path/folder/NNNNNNsuffix
  std::string FrameFile(const std::string& folder, int64_t index, const std::string& suffix) const;

  absl::Status WriteDescription(const RunDescription& description) const;
  absl::StatusOr<RunDescription> ReadDescription() const;

  // The lines of all logs, merged; indices increase. A last line that a crash cut short is left
  // out; any other damage is DataLoss, with the line's number.
  absl::StatusOr<std::vector<FrameLine>> ReadLines() const;
  // The lines of segment's log only.
  absl::StatusOr<std::vector<FrameLine>> ReadSegmentedLines() const;
  absl::StatusOr<LineLog> OpenLog() const { return LineLog::Open(File("frames.jsonl")); }
  // This process's own log, for maps that are taken over.
  absl::StatusOr<LineLog> OpenMapLog() const;

  // What the names of the files of a shot's camera begin with; first_frame: 0 for the first shot.
  static std::string CameraPrefix(const std::string& path, int64_t first_frame);
  // kOwnVehicle of each shot, and kIgnored.
  absl::StatusOr<IgnoredAreas> ReadIgnoredAreas() const;

  // Whether the files that belong to a line with a map exist and are not empty.
  bool HoldsMaps(const FrameLine& line) const;

  // Writes kMapFiles and returns how many deviations saturated.
  absl::StatusOr<int64_t> WriteGridMaps(int64_t index, const FrameMaps& maps,
                                        double deviation_full_scale) const;
  // The maps of a line with a map. The deviation is left empty unless `with_deviation` is set.
  absl::StatusOr<FrameMaps> ReadGridMaps(const FrameLine& line, const RunDescription& description,
                                         bool with_deviation) const;

 private:
  explicit RunFolder(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

// When the run in `path` ended with all its frames; empty if it has not, or if there is none.
std::string FinishedUtc(const std::string& path);

}  // namespace egosieve::tools
