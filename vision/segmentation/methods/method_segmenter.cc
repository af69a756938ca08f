#include "vision/segmentation/methods/method_segmenter.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>

#include "absl/status/status.h"
#include "kernels/base/status_macros.h"
#include "vision/descriptor/frame_descriptor.h"
#include "vision/frame/equalization.h"
#include "vision/segmentation/label_record.h"
#include "vision/segmentation/stage_timer.h"

namespace egosieve::vision {
namespace {

// Number of recent pictures kept. If a pair's first frame is older, its labels have no dense flow.
constexpr size_t kRecentFrames = 12;

FrameRecord SharedRecord(const Frame& frame, const LabelledFrame& labels) {
  FrameRecord record;
  record.frame_index = frame.index;
  record.time_seconds = frame.time_seconds;
  RecordLabels(labels, record);
  return record;
}

double DynamicShare(const SegmentationMap& map) {
  const auto dynamic = std::count_if(map.probability.begin(), map.probability.end(),
                                     [](float probability) { return probability >= 0.5f; });
  return static_cast<double>(dynamic) / static_cast<double>(map.probability.size());
}

}  // namespace

absl::StatusOr<std::unique_ptr<MethodSegmenter>> MethodSegmenter::Create(
    std::shared_ptr<kernels::Context> context, const OnlineSegmenterOptions& options,
    const std::vector<std::string>& methods) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (methods.empty()) return absl::InvalidArgumentError("no method; name one at least");
  std::unique_ptr<MethodSegmenter> segmenter(new MethodSegmenter(context, options));
  EGOSIEVE_ASSIGN_OR_RETURN(segmenter->labeller_, FrameLabeller::Create(options.labeller));
  for (const std::string& name : methods) {
    EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<MapMethod> method,
                              MakeMethod(name, context, options));
    segmenter->methods_.push_back(std::move(method));
  }
  return segmenter;
}

cv::Mat MethodSegmenter::GreyOf(int64_t frame_index) const {
  for (const Picture& picture : recent_) {
    if (picture.frame_index == frame_index) return picture.grey;
  }
  return cv::Mat();
}

absl::StatusOr<std::shared_ptr<const ExtractedFrame>> MethodSegmenter::Extract(
    const Frame& frame) const {
  return labeller_->Extract(frame);
}

absl::StatusOr<MethodAnswers> MethodSegmenter::Process(const Frame& frame) {
  double milliseconds = 0.0;
  std::shared_ptr<const ExtractedFrame> extracted;
  {
    StageTimer timer(milliseconds);
    EGOSIEVE_ASSIGN_OR_RETURN(extracted, Extract(frame));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(MethodAnswers answers, Process(frame, std::move(extracted), {}));
  answers.shared_milliseconds += milliseconds;
  return answers;
}

absl::StatusOr<MethodAnswers> MethodSegmenter::Process(
    const Frame& frame, std::shared_ptr<const ExtractedFrame> extracted,
    const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead) {
  MethodAnswers result;
  MethodInput input;
  std::vector<float> inputs, field;
  {
    StageTimer timer(result.shared_milliseconds);
    EGOSIEVE_ASSIGN_OR_RETURN(result.labels, labeller_->Label(std::move(extracted), ahead));
    prior_.Learn(result.labels);
    const auto equalized = [this](Frame picture) {
      picture.image = EqualizeLuminance(picture.image, options_.labeller.equalization);
      return picture;
    };
    if (result.labels.size() > 0) {
      EGOSIEVE_ASSIGN_OR_RETURN(
          inputs, DescribePositions(*context_, equalized(result.labels.labelled),
                                    result.labels.positions_view(), options_.descriptor));
    }
    input.grid = {frame.image.cols, frame.image.rows, options_.stride_pixels};
    EGOSIEVE_ASSIGN_OR_RETURN(
        field, DescribeGrid(*context_, equalized(frame), input.grid, options_.descriptor));
    input.grey = EqualizedGrey(frame.image, options_.labeller.equalization);
    recent_.push_back({frame.index, input.grey});
    if (recent_.size() > kRecentFrames) recent_.pop_front();
  }
  input.frame_index = frame.index;
  input.labels = &result.labels;
  if (result.labels.first_index >= 0) input.grey_before = GreyOf(result.labels.first_index);
  input.inputs = {inputs.data(), result.labels.size(), kDescriptorDimension};
  input.field = {field.data(), input.grid.size(), kDescriptorDimension};
  for (const std::unique_ptr<MapMethod>& method : methods_) {
    MethodAnswer answer;
    answer.record = SharedRecord(frame, result.labels);
    {
      StageTimer timer(answer.own_milliseconds);
      EGOSIEVE_ASSIGN_OR_RETURN(answer.map, method->Answer(input, answer.record));
    }
    if (options_.location_prior.weight > 0.0) {
      answer.without_prior = answer.map.probability;
      prior_.Apply(answer.map);
    }
    answer.record.dynamic_share = DynamicShare(answer.map);
    result.answers.push_back(std::move(answer));
  }
  return result;
}

}  // namespace egosieve::vision
