// Continuing a run that ended before its drive did, however it ended.
//
// Checkpoints lie in model/NNNNNN.npz (gp/io/model_file.h), each the state after frame NNNNNN,
// whole or absent; the last two are kept. A run continues after the newest checkpoint whose frame
// has its line; what had been written after it is written again, with the same bytes. A frame whose
// maps are gone counts as not written, nor do those after it.
//
// A run whose maps are made later keeps all its checkpoints, and in steps/NNNNNN.npz what each
// frame did to the model (vision/segmentation/learning_step.h): from a checkpoint and the steps
// after it follows the model of any frame.
#ifndef EGOSIEVE_TOOLS_SEGMENT_RESUME_H_
#define EGOSIEVE_TOOLS_SEGMENT_RESUME_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/run_folder/run_folder.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {

// Writes the checkpoint after frame `index`; removes all but the last two unless `keep_all`.
absl::Status WriteCheckpoint(const RunFolder& folder, int64_t index, const std::string& bytes,
                             bool keep_all);

absl::Status WriteStep(const RunFolder& folder, int64_t index, const std::string& bytes);
// NotFound where the frame has none.
absl::StatusOr<std::string> ReadStep(const RunFolder& folder, int64_t index);

struct CheckpointBytes {
  int64_t next_frame = 0;  // the frame after it
  std::string bytes;
};

// The newest whole checkpoint after a frame of at most `last`; none where there is none. Errors
// where one cannot be read.
absl::StatusOr<std::optional<CheckpointBytes>> FindCheckpoint(const RunFolder& folder,
                                                              int64_t last);

// The lines of the run up to the first of which a file is missing or empty: a map, or the step in a
// run that keeps them.
absl::StatusOr<std::vector<FrameLine>> ReadWholeLines(const RunFolder& folder,
                                                      const RunDescription& description);

// FailedPrecondition, naming the difference and what to do, where the run `before` in `directory`
// is not the one that `now` describes. has_other_device: that of the call differs.
absl::Status CheckSameRun(const RunDescription& before, const RunDescription& now,
                          bool has_other_device, const std::string& directory);

struct ResumePoint {
  int64_t next_frame = 0;        // index of the first frame to segment
  std::string checkpoint;        // empty: from the start
  std::vector<FrameLine> lines;  // of the frames before next_frame
};

// `from`: the run's first frame. `lines`: its whole ones.
absl::StatusOr<ResumePoint> FindResumePoint(const RunFolder& folder, int64_t from,
                                            std::vector<FrameLine> lines);

// The last `count` frames of from .. last that can be read, oldest first; fewer where there are
// fewer. Leaves the source anywhere.
absl::StatusOr<std::vector<vision::Frame>> ReadRecentFrames(vision::FrameSource& source,
                                                            int64_t from, int64_t last, int count);

// Whether the source has no frame `index`; then `warning` is that of its end. Leaves it anywhere.
bool EndsBefore(int64_t index, vision::FrameSource& source, std::string& warning);

// Temporary files of killed programs in the run folder. Those of running programs are locked and
// stay.
void RemoveAbandonedFiles(const RunFolder& folder);

// Removes the checkpoints after the frames from `next_frame` on, which are written again, and of
// the others all but the last two: a kill between the writing of one and the removal of the oldest
// leaves three. Does nothing in a run that keeps all.
absl::Status RemoveOtherCheckpoints(const RunFolder& folder, const RunDescription& description,
                                    int64_t next_frame);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_RESUME_H_
