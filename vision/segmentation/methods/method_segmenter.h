// Several methods over one drive, frame by frame: features, labels and descriptors are computed
// once and handed to all.
#ifndef EGOSIEVE_VISION_SEGMENTATION_METHODS_METHOD_SEGMENTER_H_
#define EGOSIEVE_VISION_SEGMENTATION_METHODS_METHOD_SEGMENTER_H_

#include <deque>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/runtime/context.h"
#include "vision/frame/frame.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/frame_record.h"
#include "vision/segmentation/methods/map_method.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/segmentation/segmentation_map.h"

namespace egosieve::vision {

struct MethodAnswer {
  SegmentationMap map;
  // What all share (features, labels and their times) and what is the method's own.
  FrameRecord record;
  double own_milliseconds = 0.0;  // without what all share
};

struct MethodAnswers {
  LabelledFrame labels;
  double shared_milliseconds = 0.0;   // features, labels, descriptors
  std::vector<MethodAnswer> answers;  // in the order of the methods
};

class MethodSegmenter {
 public:
  // NotFound for an unknown method; InvalidArgument for invalid options or no method.
  static absl::StatusOr<std::unique_ptr<MethodSegmenter>> Create(
      std::shared_ptr<kernels::Context> context, const OnlineSegmenterOptions& options,
      const std::vector<std::string>& methods);

  // Frames in order. Errors as OnlineSegmenter::Process.
  absl::StatusOr<MethodAnswers> Process(const Frame& frame);

  const MapMethod& method(int index) const { return *methods_[index]; }

 private:
  MethodSegmenter(std::shared_ptr<kernels::Context> context, const OnlineSegmenterOptions& options)
      : context_(std::move(context)), options_(options) {}

  cv::Mat GreyOf(int64_t frame_index) const;

  std::shared_ptr<kernels::Context> context_;
  OnlineSegmenterOptions options_;
  std::unique_ptr<FrameLabeller> labeller_;
  std::vector<std::unique_ptr<MapMethod>> methods_;
  struct Picture {
    int64_t frame_index = 0;
    cv::Mat grey;  // equalised
  };
  std::deque<Picture> recent_;  // the newest last
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_METHODS_METHOD_SEGMENTER_H_
