// The object behind an egosieve_segmenter: an online segmenter, the frames that its next pair
// needs, and a lock.
//
// A session's bytes are an archive of arrays (gp/io/array_file.h):
//
//   session_version  i8 [1]     kSessionVersion
//   options          i8 [4]     profile, stride, budget, seed
//   lag              i8 [1]
//   focal_ratio      f8 [1]
//   ignored          u1 [height, width], or [0]
//   next_frame       i8 [1]
//   checkpoint       u1 [...]   OnlineSegmenter::Checkpoint
//   waiting          i8 [1]     number of frames, at the end, that are not learnt from yet
//   indices          i8 [F]     of the frames, oldest first
//   grey             i8 [F]     1 where the frame has one channel
//   times            f8 [F]     seconds
//   frame_0, ...     u1 [height, width * channels]
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "kernels/runtime/context.h"
#include "tools/embed/c/handle_table.h"
#include "tools/embed/include/egosieve/segmenter.h"
#include "vision/frame/frame.h"
#include "vision/image/image_view.h"
#include "vision/segmentation/frame_record.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/segmentation/segmentation_map.h"

namespace egosieve::embed {

inline constexpr int64_t kSessionVersion = 3;

// Errors are thrown.
class SegmenterSession {
 public:
  struct Result {
    vision::SegmentationMap map;  // empty where it was not wanted
    vision::FrameRecord record;
  };

  // Of the options all but device and ignore; ignored: vision/frame/ignored_area.h.
  SegmenterSession(std::shared_ptr<kernels::Context> context,
                   const egosieve_segmenter_options& options, cv::Mat1b ignored);
  static std::shared_ptr<SegmenterSession> FromBytes(std::shared_ptr<kernels::Context> context,
                                                     std::string_view bytes);

  // Takes a copy of the image, and learns from the frame that came `lag` frames before; returns
  // nothing if there is none. With a lag all frames must have one size, with an ignored area its
  // size; otherwise InvalidArgument. After an error of the device the frame counts as taken in, and
  // may have been learnt from.
  std::optional<Result> Process(const vision::ImageView& image, double time_seconds,
                                bool map_wanted);
  // Learns from the next frame that waits for later frames; returns nothing if none waits.
  std::optional<Result> Finish(bool map_wanted);
  // How many frames were taken in, those before ToBytes included.
  int64_t FrameCount();
  // How many frames wait, and their size.
  std::pair<int64_t, cv::Size> WaitingFrames();
  std::string ToBytes();

  int stride() const { return options_.stride; }
  const cv::Mat1b& ignored() const { return ignored_; }

 private:
  struct Waiting {
    vision::Frame frame;
    std::shared_ptr<const vision::ExtractedFrame> extracted;
  };

  Result LearnOldest(bool map_wanted);

  const egosieve_segmenter_options options_;
  const cv::Mat1b ignored_;
  std::mutex mutex_;  // guards all members below
  std::unique_ptr<vision::OnlineSegmenter> segmenter_;
  std::deque<vision::Frame> recent_;  // of the last HistoryFrames() pictures learnt from
  std::deque<Waiting> waiting_;       // frames after these, at most `lag`
  int64_t next_frame_ = 0;
};

template <>
struct HandleOf<egosieve_segmenter> {
  using Object = SegmenterSession;
  static constexpr uint64_t kKind = 3;
  static constexpr char kName[] = "segmenter";
};

}  // namespace egosieve::embed
