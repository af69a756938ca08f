#include "tools/infer/model_replay.h"

#include <algorithm>
#include <optional>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/segment/resume.h"

namespace egosieve::tools {

absl::Status ModelReplay::ReadLines() {
  EGOSIEVE_ASSIGN_OR_RETURN(lines_, run_.ReadLines());
  return absl::OkStatus();
}

absl::Status ModelReplay::MoveTo(int64_t index) {
  if (index < next_frame_) {
    return absl::InternalError(absl::StrCat("the model is behind frame ", index));
  }
  const bool passes_checkpoint =
      checkpoint_every_ > 0 && index / checkpoint_every_ > next_frame_ / checkpoint_every_;
  if (passes_checkpoint) {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<CheckpointBytes> checkpoint,
                              FindCheckpoint(run_, index - 1));
    if (checkpoint.has_value() && checkpoint->next_frame > next_frame_) {
      EGOSIEVE_RETURN_IF_ERROR(segmenter_->Restore(checkpoint->bytes, {}));
      next_frame_ = checkpoint->next_frame;
    }
  }
  for (const FrameLine& line : lines_) {
    if (line.index < next_frame_ || line.index >= index) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string step, StepOf(line.index));
    if (!step.empty()) EGOSIEVE_RETURN_IF_ERROR(segmenter_->Replay(step));
    if (checkpoint_every_ > 0 && (line.index + 1) % checkpoint_every_ == 0) {
      EGOSIEVE_RETURN_IF_ERROR(segmenter_->Checkpoint().status());
    }
  }
  next_frame_ = index;
  return absl::OkStatus();
}

absl::StatusOr<std::string> ModelReplay::StepOf(int64_t index) const {
  const auto line = std::lower_bound(
      lines_.begin(), lines_.end(), index,
      [](const FrameLine& candidate, int64_t target) { return candidate.index < target; });
  if (line == lines_.end() || line->index != index) {
    return absl::DataLossError(absl::StrCat("the run in ", run_.path(), " has no frame ", index,
                                            "; segment the drive again"));
  }
  if (line->outcome == FrameLine::Outcome::kFailed) return std::string();
  absl::StatusOr<std::string> step = ReadStep(run_, index);
  if (!absl::IsNotFound(step.status())) return step;
  return absl::DataLossError(
      absl::StrCat("the model of frame ", index, " is missing: ", step.status().message()));
}

vision::OnlineSegmenter& ModelReplay::Lend(int64_t end) {
  next_frame_ = end;
  return *segmenter_;
}

}  // namespace egosieve::tools
