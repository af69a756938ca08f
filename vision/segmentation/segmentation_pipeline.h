// A drive through the segmenter with its stages overlapped:
//
//   read -> extract features -> learn -> infer -> sink
//
// One thread a stage and a bounded queue between neighbours, so that every stage sees the frames in
// order: the results are those of OnlineSegmenter::Process frame by frame, byte for byte. Learning
// is the only stage whose result for a frame depends on the frames before it.
#ifndef EGOSIEVE_VISION_SEGMENTATION_SEGMENTATION_PIPELINE_H_
#define EGOSIEVE_VISION_SEGMENTATION_SEGMENTATION_PIPELINE_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/frame/frame.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/segmentation/frame_record.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/segmentation/segmentation_map.h"

namespace egosieve::vision {

struct PipelineOptions {
  bool overlap = true;      // false: one frame after the other, on the caller's thread
  int queue_capacity = 3;   // frames between two stages; at least 1
  int64_t first_frame = 0;  // index in the input
  int64_t end_frame = -1;   // index behind the last frame; -1: the end of the input
  // A checkpoint comes with every frame whose index + 1 is a multiple of this; 0: none. Checkpoints
  // rebuild the model's factor: runs agree to the last bit only where this agrees.
  int64_t checkpoint_interval = 0;

  absl::Status Validate() const;
};

// What the sink gets, one a frame, in the order of the input.
struct SegmentedFrame {
  int64_t index = 0;
  double read_milliseconds = 0.0;
  // Why there is no picture; then nothing below is set but the record's index and reason.
  std::optional<std::string> damage;
  Frame frame;
  LabelledFrame labels;
  SegmentationMap map;
  FrameRecord record;
  std::string checkpoint;  // of the segmenter after this frame; empty where none is due
};

struct PipelineSummary {
  int64_t segmented_frames = 0;
  int64_t damaged_frames = 0;
  int64_t unlearnt_frames = 0;  // segmented, but not learnt from
  bool stopped = false;         // stop_requested said so before the end of the input
  std::string warning;          // of the source's end
};

// Called on one thread, not the caller's where stages overlap. An error ends the run.
using SegmentedFrameSink = std::function<absl::Status(const SegmentedFrame&)>;

// Runs to the end of the source, to `end_frame`, or until `stop_requested` (asked before every
// read, from another thread) returns true; frames that were read by then are finished. Returns the
// first error of source, segmenter or sink; the sink has then seen every frame before the error's.
absl::StatusOr<PipelineSummary> RunPipeline(FrameSource& source, OnlineSegmenter& segmenter,
                                            const PipelineOptions& options,
                                            const std::function<bool()>& stop_requested,
                                            const SegmentedFrameSink& sink);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_SEGMENTATION_PIPELINE_H_
