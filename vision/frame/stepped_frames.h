// Every n-th frame of a source, with its index, time and name there. The pictures between are not
// read; those of a video are decoded where it cannot seek over them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "kernels/base/status_macros.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {

class SteppedFrames : public FrameSource {
 public:
  // Delivers first, first + step, ...; first >= 0, step >= 1.
  SteppedFrames(std::unique_ptr<FrameSource> source, int64_t first, int64_t step)
      : source_(std::move(source)), first_(first), step_(step), next_(first) {}

  absl::StatusOr<FrameRead> Next() override {
    EGOSIEVE_RETURN_IF_ERROR(source_->SeekTo(next_));
    EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, source_->Next());
    if (!std::holds_alternative<EndOfFrames>(read)) next_ += step_;
    return read;
  }
  // Goes to the first delivered frame at `index` or after it.
  absl::Status SeekTo(int64_t index) override {
    EGOSIEVE_RETURN_IF_ERROR(source_->SeekTo(index));
    const int64_t steps = (std::max(index, first_) - first_ + step_ - 1) / step_;
    next_ = first_ + steps * step_;
    return absl::OkStatus();
  }
  int64_t next_index() const override { return next_; }
  int64_t expected_frame_count() const override { return source_->expected_frame_count(); }
  std::vector<std::string> files() const override { return source_->files(); }
  std::string image_name(int64_t index) const override { return source_->image_name(index); }
  std::vector<std::string> remarks() const override { return source_->remarks(); }
  std::string description() const override { return source_->description(); }

 private:
  std::unique_ptr<FrameSource> source_;
  int64_t first_, step_, next_;
};

}  // namespace egosieve::vision
