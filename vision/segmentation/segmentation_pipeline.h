// A drive through the segmenter with its stages overlapped:
//
//   read -> extract features -> look ahead -> label -> learn -> infer -> sink
//
// A frame is labelled when the segmenter's ahead_frames after it have been extracted, so that its
// labels can use pictures before and after it.
//
// One thread per stage and a bounded queue between neighbours, so that every stage sees the frames
// in order: the results are those of the same calls in turn, byte for byte. Labelling and learning
// are the stages whose result for a frame depends on the frames before it.
//
// Learning and inference can be done at two times: a run that records its steps
// (learning_step.h) lets another one, given these, skip extraction and learning and infer the same
// maps later, elsewhere, for other frames or at another stride.
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
  int64_t end_frame = -1;   // index after the last frame; -1: the end of the input
  int64_t frame_step = 1;   // between the indices of the source's frames; at least 1
  // A checkpoint comes with every frame whose index + 1 is a multiple of this, or passes one; 0:
  // none. Checkpoints rebuild the model's factor: runs agree to the last bit only where this
  // agrees.
  int64_t checkpoint_interval = 0;

  // The frames that get a map; null: all. Frames without one are learnt from all the same.
  std::function<bool(int64_t index)> wants_map;
  bool record_steps = false;  // SegmentedFrame::step is filled

  // Replay: the step that was recorded for a frame, or "" where there is none, a damaged frame's.
  // Null: extract and learn. Set, checkpoint_interval must be the recorded run's; no checkpoint
  // is given, and records have no more than what inference adds.
  std::function<absl::StatusOr<std::string>(int64_t index)> recorded_step;

  bool WantsMap(int64_t index) const { return wants_map == nullptr || wants_map(index); }
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
  SegmentationMap map;  // empty where the frame gets none
  FrameRecord record;
  std::string checkpoint;  // of the segmenter after this frame; empty where none is due
  std::string step;        // what was learnt; empty where it is not recorded, or nothing came
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
// read and, where stages overlap, before a frame is learnt from, on the stages' threads) returns
// true; frames that were learnt from by then are finished, others are left out. Returns the first
// error of source, segmenter or sink; the sink has then seen every frame before the error's,
// but those that waited for frames ahead of them.
absl::StatusOr<PipelineSummary> RunPipeline(FrameSource& source, OnlineSegmenter& segmenter,
                                            const PipelineOptions& options,
                                            const std::function<bool()>& stop_requested,
                                            const SegmentedFrameSink& sink);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_SEGMENTATION_PIPELINE_H_
