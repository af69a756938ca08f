// A drive of any length made of a few clips: each clip is played back and forth, and after every
// `turn` frames the next clip follows.
//
//   frame i of a clip of n pictures shows picture  p(i) = n - 1 - |n - 1 - i mod (2 n - 2)|
//
// so that neighbouring frames are neighbours in the clip.
#ifndef EGOSIEVE_BENCH_DRIVE_PLAYED_SOURCE_H_
#define EGOSIEVE_BENCH_DRIVE_PLAYED_SOURCE_H_

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::bench {

struct Clip {
  int64_t size = 0;
  // Reads picture 0 .. size - 1. Decodes it again at each call if decoding is part of the
  // measurement.
  std::function<absl::StatusOr<cv::Mat>(int64_t picture)> read;
};

// p(i) above; size >= 1.
int64_t PictureOf(int64_t frame, int64_t size);

class PlayedSource : public vision::FrameSource {
 public:
  PlayedSource(std::vector<Clip> clips, int64_t turn, int64_t count)
      : clips_(std::move(clips)), turn_(turn), count_(count) {}

  absl::StatusOr<vision::FrameRead> Next() override;
  absl::Status SeekTo(int64_t index) override;
  int64_t next_index() const override { return next_; }
  int64_t expected_frame_count() const override { return count_; }
  std::string description() const override { return "clips played back and forth"; }

 private:
  std::vector<Clip> clips_;
  int64_t turn_ = 0, count_ = 0, next_ = 0;
};

// The pictures of a folder, read from disk at each call.
absl::StatusOr<Clip> FolderClip(const std::string& folder);
// A clip's pictures, read once, scaled to `size`, and kept in memory.
absl::StatusOr<Clip> KeptClip(const Clip& clip, cv::Size size);
// `count` pictures of the synthetic junction at 10 per second.
absl::StatusOr<Clip> SyntheticClip(int64_t count, cv::Size size);

}  // namespace egosieve::bench

#endif  // EGOSIEVE_BENCH_DRIVE_PLAYED_SOURCE_H_
