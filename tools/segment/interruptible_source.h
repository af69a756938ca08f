// Passes on another source's frames, counts them, and returns the error Cancelled when the program
// is asked to stop. For passes over a drive that write nothing.
#ifndef EGOSIEVE_TOOLS_SEGMENT_INTERRUPTIBLE_SOURCE_H_
#define EGOSIEVE_TOOLS_SEGMENT_INTERRUPTIBLE_SOURCE_H_

#include <cstdint>
#include <string>

#include "tools/cli/progress.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {

class InterruptibleSource : public vision::FrameSource {
 public:
  InterruptibleSource(vision::FrameSource& source, Progress& progress)
      : source_(source), progress_(progress) {}

  absl::StatusOr<vision::FrameRead> Next() override {
    if (!progress_.AdvanceUninterrupted()) {
      return absl::CancelledError("interrupted before the first frame; nothing was written");
    }
    return source_.Next();
  }
  absl::Status SeekTo(int64_t index) override { return source_.SeekTo(index); }
  int64_t next_index() const override { return source_.next_index(); }
  int64_t expected_frame_count() const override { return source_.expected_frame_count(); }
  std::string description() const override { return source_.description(); }

 private:
  vision::FrameSource& source_;
  Progress& progress_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_INTERRUPTIBLE_SOURCE_H_
