#include "vision/frame/stepped_frames.h"

#include <algorithm>

#include "kernels/base/status_macros.h"

namespace egosieve::vision {

absl::StatusOr<FrameRead> SteppedFrames::Next() {
  EGOSIEVE_RETURN_IF_ERROR(source_->SeekTo(next_));
  EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, source_->Next());
  if (!std::holds_alternative<EndOfFrames>(read)) next_ += step_;
  return read;
}

absl::Status SteppedFrames::SeekTo(int64_t index) {
  EGOSIEVE_RETURN_IF_ERROR(source_->SeekTo(index));
  const int64_t steps = (std::max(index, first_) - first_ + step_ - 1) / step_;
  next_ = first_ + steps * step_;
  return absl::OkStatus();
}

}  // namespace egosieve::vision
