// A source of frames that are made, some of which cannot be read.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "vision/frame/frame_source.h"

namespace egosieve::vision {

class FakeSource : public FrameSource {
 public:
  // Frames 0 to count - 1, of which `damaged` cannot be read.
  FakeSource(int64_t count, std::set<int64_t> damaged, std::function<Frame(int64_t)> frame)
      : count_(count), damaged_(std::move(damaged)), frame_(std::move(frame)) {}

  absl::StatusOr<FrameRead> Next() override {
    if (next_ >= count_) return EndOfFrames{count_, "the end"};
    const int64_t index = next_++;
    if (damaged_.contains(index)) return DamagedFrame{index, "torn"};
    return frame_(index);
  }
  absl::Status SeekTo(int64_t index) override {
    next_ = index;
    return absl::OkStatus();
  }
  int64_t next_index() const override { return next_; }
  int64_t expected_frame_count() const override { return count_; }
  std::string description() const override { return "made frames"; }

 private:
  const int64_t count_;
  const std::set<int64_t> damaged_;
  const std::function<Frame(int64_t)> frame_;
  int64_t next_ = 0;
};

}  // namespace egosieve::vision
