// The model of any frame of a run that keeps its models: from a checkpoint and the steps after it
// (tools/segment/resume.h).
#ifndef EGOSIEVE_TOOLS_INFER_MODEL_REPLAY_H_
#define EGOSIEVE_TOOLS_INFER_MODEL_REPLAY_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/run_folder/run_folder.h"
#include "vision/segmentation/online_segmenter.h"

namespace egosieve::tools {

class ModelReplay {
 public:
  // `checkpoint_every`: the run's; 0: it has none. `segmenter` is new.
  ModelReplay(const RunFolder& run, int64_t checkpoint_every,
              std::unique_ptr<vision::OnlineSegmenter> segmenter)
      : run_(run), checkpoint_every_(checkpoint_every), segmenter_(std::move(segmenter)) {}

  // The run as it is now, which segment may still be writing.
  absl::Status ReadLines();
  const std::vector<FrameLine>& lines() const { return lines_; }

  // Makes the model that of the moment before frame `index`: from where it is, or from a checkpoint
  // that is nearer.
  absl::Status MoveTo(int64_t index);
  // What frame `index` did to the model; empty for one that could not be read. DataLoss where the
  // run has no such frame or lost its step.
  absl::StatusOr<std::string> StepOf(int64_t index) const;
  // For a pipeline that replays the frames up to `end`; one that does not get there leaves the
  // model to be made anew.
  vision::OnlineSegmenter& Lend(int64_t end);

 private:
  RunFolder run_;
  int64_t checkpoint_every_ = 0;
  std::unique_ptr<vision::OnlineSegmenter> segmenter_;
  std::vector<FrameLine> lines_;
  int64_t next_frame_ = 0;  // that the model has not seen
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_MODEL_REPLAY_H_
