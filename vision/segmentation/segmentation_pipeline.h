// Runs a drive through the segmenter with overlapped stages:
//
//   read -> extract features -> look ahead -> label -> learn -> infer -> sink
//
// A frame is labelled once the `ahead_frames` frames after it have been extracted, so that its
// labels can use pictures before and after it.
//
// There is one thread per stage and a bounded queue between neighbouring stages, so that every
// stage sees the frames in order. The results are those of the same calls one after the other, byte
// for byte. Only in labelling and learning does a frame's result depend on the frames before it.
#pragma once

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
  int64_t frame_step = 1;   // difference of successive frame indices of the source; at least 1
  // A checkpoint is made after every frame whose index + 1 is a multiple of this, or passes one; 0:
  // none. Checkpoints rebuild the model's factor: two runs agree to the last bit only if their
  // intervals agree.
  int64_t checkpoint_interval = 0;
};

// The sink's input, one per frame, in the order of the input.
struct SegmentedFrame {
  int64_t index = 0;
  double read_milliseconds = 0.0;
  // Why there is no picture. If set, of the fields below only the record's index and reason are
  // set, and the checkpoint if one is due.
  std::optional<std::string> damage;
  Frame frame;
  LabelledFrame labels;
  SegmentationMap map;  // empty if the frame gets none
  FrameRecord record;
  std::string checkpoint;  // of the segmenter after this frame; empty if none is due
};

struct PipelineSummary {
  int64_t segmented_frames = 0;
  int64_t damaged_frames = 0;
  bool stopped = false;  // by stop_requested, before the end of the input
  std::string warning;   // from the source at its end
};

// Called on one thread; with overlap it is not the caller's thread. An error ends the run.
using SegmentedFrameSink = std::function<absl::Status(const SegmentedFrame&)>;

// Runs to the end of the source, to `end_frame`, or until `stop_requested` returns true. It is
// called before every read and, with overlap, before each frame is learnt, on the stages' threads.
// Frames that were learnt by then are finished, others are left out. Returns the first error of
// source, segmenter or sink. The sink has then received every frame before the error, except frames
// that waited for frames ahead of them.
absl::StatusOr<PipelineSummary> RunPipeline(FrameSource& source, OnlineSegmenter& segmenter,
                                            const PipelineOptions& options,
                                            const std::function<bool()>& stop_requested,
                                            const SegmentedFrameSink& sink);

}  // namespace egosieve::vision
