// The maps of a run folder that are made after its lines: written as they come, and entered into
// the lines by batches.
//
// A line says that its frame has a map only once the map lies there whole. Several programs may
// fill one folder at the same time, each its own frames: the log is read, changed and replaced
// under a lock on the folder. A program that is killed loses the entries of its last batch; making
// these maps again gives the same bytes.
#ifndef EGOSIEVE_TOOLS_INFER_MAP_BOOK_H_
#define EGOSIEVE_TOOLS_INFER_MAP_BOOK_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "tools/run_folder/run_folder.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {

class MapBook {
 public:
  // `folder` holds `description`, and the lines that are to be there or at least those that an
  // earlier program had entered: the others are added. Maps will come from `device`.
  static absl::StatusOr<MapBook> Open(const RunFolder& folder, const RunDescription& description,
                                      absl::Span<const FrameLine> to_be_there,
                                      const std::string& device);

  const std::map<int64_t, FrameLine>& lines() const { return lines_; }

  // Writes the frame's maps; a frame that could not be read gets the last map before it, where
  // there is one. NotFound where the frame has no line.
  absl::Status Write(const vision::SegmentedFrame& frame);

  // Enters what was written since the last call.
  absl::Status Enter();

 private:
  MapBook(const RunFolder& folder, const RunDescription& description, const std::string& device)
      : folder_(folder), description_(description), device_(device) {}

  RunFolder folder_;
  RunDescription description_;
  std::string device_;
  std::map<int64_t, FrameLine> lines_;
  std::vector<int64_t> not_entered_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_MAP_BOOK_H_
