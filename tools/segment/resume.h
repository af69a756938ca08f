// Continues a run that ended before its drive did, for any reason.
//
// Checkpoints are model/NNNNNN.npz (gp/io/model_file.h), each with the state after frame NNNNNN.
// They are complete or absent; the last two are kept. A run continues after the newest checkpoint
// whose frame has its line. Later frames are written again, with the same bytes. A frame with
// missing maps counts as not written, and so do all frames after it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/run_folder/run_folder.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {

// Writes the checkpoint after frame `index`; removes all but the last two.
absl::Status WriteCheckpoint(const RunFolder& folder, int64_t index, const std::string& bytes);

// The lines of the run before the first line with a missing or empty map.
absl::StatusOr<std::vector<FrameLine>> ReadWholeLines(const RunFolder& folder);

struct ResumePoint {
  int64_t next_frame = 0;        // index of the first frame to segment
  std::string checkpoint;        // empty: from the start
  std::vector<FrameLine> lines;  // of the frames before next_frame
};

// `from`: the run's first frame. `lines`: its complete lines. Errors if a checkpoint cannot be read.
absl::StatusOr<ResumePoint> FindResumePoint(const RunFolder& folder, int64_t from,
                                            std::vector<FrameLine> lines);

// The frames of the last `count` pictures of from .. last (repeated_picture.h), oldest first; fewer
// if there are fewer. Leaves the source at any frame.
absl::StatusOr<std::vector<vision::Frame>> ReadRecentFrames(vision::FrameSource& source,
                                                            int64_t from, int64_t last, int count);

// Removes the checkpoints of frames from `next_frame` on, because those frames are written again.
// Of the others, all but the last two are removed: a kill between the writing of one and the
// removal of the oldest leaves three.
absl::Status RemoveOtherCheckpoints(const RunFolder& folder, int64_t next_frame);

}  // namespace egosieve::tools
