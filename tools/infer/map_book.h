// Maps of a run folder that are made after its lines: each map is written, then its line is
// appended to this program's own log (tools/run_folder/run_folder.h). A line states that its frame
// has a map only after the complete map has been written.
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
  // The maps will be made on `device`.
  static absl::StatusOr<MapBook> Open(const RunFolder& folder, const RunDescription& description,
                                      const std::string& device);

  // Whether the frame's line states that it has a map, and the map exists.
  bool Holds(int64_t index);
  // Adds a line that the folder does not have yet.
  absl::Status Add(const FrameLine& line);

  const std::map<int64_t, FrameLine>& lines() const { return lines_; }

  // Writes the frame's maps and its line. A frame that could not be read gets the last map before
  // it, if there is one. NotFound if the frame has no line.
  absl::Status Write(const vision::SegmentedFrame& frame);

 private:
  MapBook(const RunFolder& folder, const RunDescription& description, const std::string& device)
      : folder_(folder), description_(description), device_(device) {}

  absl::Status Append(const FrameLine& line);

  RunFolder folder_;
  RunDescription description_;
  std::string device_;
  std::map<int64_t, FrameLine> lines_;
  std::map<int64_t, bool> holds_;  // results of earlier look-ups on the disk
  std::optional<LineLog> log_;     // opened at the first line
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_MAP_BOOK_H_
