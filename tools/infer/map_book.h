// The maps of a run folder that are made after its lines: each is written, then its line is
// appended to this program's own log (tools/run_folder/run_folder.h).
//
// A line says that its frame has a map only once the map lies there whole. Any number of programs,
// on any number of machines, may fill one folder at the same time, also while segment writes it:
// none waits for another or changes another's file. A map that two of them make has the same bytes.
#ifndef EGOSIEVE_TOOLS_INFER_MAP_BOOK_H_
#define EGOSIEVE_TOOLS_INFER_MAP_BOOK_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/run_folder/line_log.h"
#include "tools/run_folder/run_folder.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {

class MapBook {
 public:
  // Maps will come from `device`.
  static absl::StatusOr<MapBook> Open(const RunFolder& folder, const RunDescription& description,
                                      const std::string& device);

  // By the logs as they are now.
  absl::Status Refresh();
  // The frames whose lines say that they have a map, and which have it.
  bool Holds(int64_t index);
  // Enters a line that the folder does not have yet.
  absl::Status Add(const FrameLine& line);

  const std::map<int64_t, FrameLine>& lines() const { return lines_; }

  // Writes the frame's maps and its line; a frame that could not be read gets the last map before
  // it, where there is one. NotFound where the frame has no line.
  absl::Status Write(const vision::SegmentedFrame& frame);

 private:
  MapBook(const RunFolder& folder, const RunDescription& description, const std::string& device)
      : folder_(folder), description_(description), device_(device) {}

  absl::Status Append(const FrameLine& line);

  RunFolder folder_;
  RunDescription description_;
  std::string device_;
  std::map<int64_t, FrameLine> lines_;
  std::map<int64_t, bool> holds_;  // what has been looked for on the disk
  std::optional<LineLog> log_;     // from the first line on
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_MAP_BOOK_H_
