// The model at any frame of a run that keeps its models: from a checkpoint and the steps after it
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
  // `checkpoint_every`: that of the run; 0: it has no checkpoints. `segmenter` is new.
  ModelReplay(const RunFolder& run, int64_t checkpoint_every,
              std::unique_ptr<vision::OnlineSegmenter> segmenter)
      : run_(run), checkpoint_every_(checkpoint_every), segmenter_(std::move(segmenter)) {}

  // Reads the run's lines.
  absl::Status ReadLines();
  const std::vector<FrameLine>& lines() const { return lines_; }

  // Sets the model to its state before frame `index`, starting from its present state or from a
  // nearer checkpoint.
  absl::Status MoveTo(int64_t index);
  // The step of frame `index`; empty if the frame could not be read. DataLoss if the run has no
  // such frame or has lost its step.
  absl::StatusOr<std::string> StepOf(int64_t index) const;
  // Lends the segmenter to a pipeline that replays the frames up to `end`. If the pipeline stops
  // earlier, the model must be made again.
  vision::OnlineSegmenter& Lend(int64_t end);

 private:
  RunFolder run_;
  int64_t checkpoint_every_ = 0;
  std::unique_ptr<vision::OnlineSegmenter> segmenter_;
  std::vector<FrameLine> lines_;
  int64_t next_frame_ = 0;  // the first frame that the model has not seen
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_MODEL_REPLAY_H_
