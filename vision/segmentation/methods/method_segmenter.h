// Runs several methods over one drive, frame by frame. Features, labels and descriptors are
// computed once for all methods, and the same location prior (location_prior.h) applies to every
// map.
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
#include "vision/segmentation/location_prior.h"
#include "vision/segmentation/methods/map_method.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/segmentation/segmentation_map.h"

namespace egosieve::vision {

struct MethodAnswer {
  SegmentationMap map;
  // The map's probability without the location prior; empty where the prior has weight 0.
  std::vector<float> without_prior;
  // Shared fields (features, labels and their times) and the method's own.
  FrameRecord record;
  double own_milliseconds = 0.0;  // without the shared steps
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

  // As OnlineSegmenter's Extract, Learn and Infer together: frames in order.
  absl::StatusOr<std::shared_ptr<const ExtractedFrame>> Extract(const Frame& frame) const;
  absl::StatusOr<MethodAnswers> Process(
      const Frame& frame, std::shared_ptr<const ExtractedFrame> extracted,
      const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead);
  // Extract and Process, without frames ahead.
  absl::StatusOr<MethodAnswers> Process(const Frame& frame);

  const OnlineSegmenterOptions& options() const { return options_; }
  const MapMethod& method(int index) const { return *methods_[index]; }

 private:
  MethodSegmenter(std::shared_ptr<kernels::Context> context, const OnlineSegmenterOptions& options)
      : context_(std::move(context)), options_(options), prior_(options.location_prior) {}

  cv::Mat GreyOf(int64_t frame_index) const;

  std::shared_ptr<kernels::Context> context_;
  OnlineSegmenterOptions options_;
  std::unique_ptr<FrameLabeller> labeller_;
  std::vector<std::unique_ptr<MapMethod>> methods_;
  LocationPrior prior_;
  struct Picture {
    int64_t frame_index = 0;
    cv::Mat grey;  // equalised
  };
  std::deque<Picture> recent_;  // newest last
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_METHODS_METHOD_SEGMENTER_H_
