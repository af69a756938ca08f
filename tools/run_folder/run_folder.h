// The output folder of a drive: where everything lies, and how it is written and read.
//
//   run.json                       RunDescription
//   frames.jsonl                   a FrameLine a line, in the order of the frames: segment's log
//   log/TIME-HOST-PID.jsonl        the lines of maps that were made later, a log for each program
//                                  that makes them; who reads merges them
//   grid/NNNNNN.{prob,std}.png     maps at grid resolution (map_image.h)
//   potential/NNNNNN.png           with segment --potential: what looks like the things that move,
//                                  at grid resolution, value / 65535
//   masks/, ids/, tracks.csv, full/    what reconstruct makes (tools/reconstruct/frame_products.h);
//   reconstruct.json                   how far it is
//   refined/, refined.json         what its shares make (tools/reconstruct/refined_maps.h)
//   camera.json, own_vehicle.png, fixed_pattern.png, windscreen.png
//                                  what a first pass learnt (tools/segment/run_camera.h)
//   ignored.png                    the user's own mask of what is not the world
//   frames/NNNNNN.png              pictures of a stream (segment --record)
//   render/NNNNNN.png              overlays
//   model/                         checkpoints
//   steps/NNNNNN.npz               what the frame did to the model, where maps are made later
//   report.html, overlay.mp4, eval.json, eval.csv, further.json, plots/
//
// NNNNNN is the frame's index in the input, from 0. A frame's maps are written before its line: a
// frame that has a line has its maps, whole. Logs only grow, so that programs on several machines
// may fill one folder without waiting for each other; a map that is made twice has the same bytes.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_RUN_FOLDER_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_RUN_FOLDER_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/line_log.h"
#include "tools/run_folder/run_description.h"

namespace egosieve::tools {

struct FrameMaps {
  cv::Mat1f probability;
  cv::Mat1f deviation;
  cv::Mat1f potential;  // empty: none
};

// A file of a frame's maps: folder/NNNNNNsuffix.
struct MapFile {
  const char* folder;
  const char* suffix;
};
// Those that a run's maps consist of, the probability, by which a map is known, last.
inline constexpr MapFile kMapFiles[] = {
    {"potential", ".png"}, {"grid", ".std.png"}, {"grid", ".prob.png"}};

// The folder's absolute path, the same however it is written.
std::string AbsolutePath(const std::string& path);

// The grid of a frame's maps: the run's, but for the frame's own size.
kernels::ImageGrid GridOf(const FrameLine& line, const RunDescription& description);

// Where a frame shows what is not the world: 255, else 0; of the frame's size. `ignored` is the
// run's ReadIgnoredArea(), the rest the frame's own.
cv::Mat1b IgnoredIn(const FrameLine& line, const cv::Mat1b& ignored);

class RunFolder {
 public:
  static constexpr char kOwnVehicle[] = "own_vehicle.png", kIgnored[] = "ignored.png",
                        kFixedPattern[] = "fixed_pattern.png", kWindscreen[] = "windscreen.png",
                        kRecorded[] = "frames";

  // Makes the folder and its parents. A folder that holds something is refused (AlreadyExists)
  // unless `overwrite` is set and it is a run folder that no other program works with
  // (folder_lock.h): then a former run's files are removed, and only those (former_run.h); what is
  // left is named on stderr. What a kill leaves before the first run.json counts as nothing.
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

  // Those of all logs, merged. A last line that a crash cut short is left out; any other damage is
  // DataLoss, with the line's number. Indices increase.
  absl::StatusOr<std::vector<FrameLine>> ReadLines() const;
  // Those of segment alone.
  absl::StatusOr<std::vector<FrameLine>> ReadSegmentedLines() const;
  absl::StatusOr<LineLog> OpenLog() const { return LineLog::Open(File("frames.jsonl")); }
  // This process's own log of maps that are made later.
  absl::StatusOr<LineLog> OpenMapLog() const;

  // Where kOwnVehicle or kIgnored is not 0: 255, else 0; empty where there is neither.
  absl::StatusOr<cv::Mat1b> ReadIgnoredArea() const;

  // Whether the files that belong to a line with a map are there and not empty.
  bool HoldsMaps(const FrameLine& line, const RunDescription& description) const;

  // Writes kMapFiles and returns how many deviations saturated. An empty deviation (means only) or
  // potential is not written.
  absl::StatusOr<int64_t> WriteGridMaps(int64_t index, const FrameMaps& maps,
                                        double deviation_full_scale) const;
  // The maps of a line that has them, without the potential. The deviation is left empty where
  // `with_deviation` is not set.
  absl::StatusOr<FrameMaps> ReadGridMaps(const FrameLine& line, const RunDescription& description,
                                         bool with_deviation) const;
  // NotFound where the run has none.
  absl::StatusOr<cv::Mat1f> ReadPotential(const FrameLine& line,
                                          const RunDescription& description) const;

 private:
  explicit RunFolder(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_RUN_FOLDER_H_
