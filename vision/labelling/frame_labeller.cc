#include "vision/labelling/frame_labeller.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/geometry/residual.h"
#include "vision/geometry/sampling.h"
#include "vision/labelling/extracted_frame.h"
#include "vision/labelling/label_rule.h"
#include "vision/labelling/pair_builder.h"
#include "vision/labelling/stopwatch.h"

namespace egosieve::vision {
namespace {

constexpr double kStateVersion = 1.0;
constexpr size_t kStateSize = 3;
constexpr uint64_t kGeometryStep = 1;
// Matches among features that look alike by chance come to a few in a hundred; pictures of one
// scene share more.
constexpr double kLeastMatchShare = 0.03;

bool SamePixels(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

void SetOutcome(LabelOutcome outcome, std::string reason, LabelledFrame& result) {
  result.outcome = outcome;
  result.reason = std::move(reason);
}

cv::Matx33d ToMatx(const Eigen::Matrix3d& m) {
  cv::Matx33d result;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result(i, j) = m(i, j);
  }
  return result;
}

bool IsInside(double x, double y, cv::Size size) {
  return x >= 0 && y >= 0 && x <= size.width - 1 && y <= size.height - 1;
}

}  // namespace

class FrameLabeller::Implementation {
 public:
  explicit Implementation(const FrameLabellerOptions& options) : options_(options) {}

  absl::StatusOr<std::shared_ptr<const ExtractedFrame>> Extract(const Frame& frame) const;
  absl::StatusOr<LabelledFrame> Label(std::shared_ptr<const ExtractedFrame> frame);
  absl::Status Push(std::shared_ptr<const ExtractedFrame> frame);

  std::vector<double> state() const {
    return {kStateVersion, mixture_.noise_pixels, mixture_.dynamic_share};
  }
  absl::Status Restore(const std::vector<double>& state);
  const FrameLabellerOptions& options() const { return options_; }

 private:
  absl::Status CheckOrder(const ExtractedFrame& frame) const;
  // The other frame of the pair that ends in the current one.
  const std::shared_ptr<const ExtractedFrame>& Earlier() const {
    return options_.frame_gap > 0 ? history_.front() : history_.back();
  }
  absl::Status LabelPair(const ExtractedFrame& first, const ExtractedFrame& second,
                         LabelledFrame& result);
  void GiveLabels(const ExtractedFrame& labelled, const std::vector<PointPair>& pairs,
                  const MotionModel& model, LabelledFrame& result);

  const FrameLabellerOptions options_;
  std::deque<std::shared_ptr<const ExtractedFrame>> history_;  // at most frame_gap, oldest first
  MixtureState mixture_;
};

absl::StatusOr<std::shared_ptr<const ExtractedFrame>> FrameLabeller::Implementation::Extract(
    const Frame& frame) const {
  if (frame.image.empty() || frame.image.type() != CV_8UC3) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame ", frame.index, ": the image is empty or not 8-bit BGR"));
  }
  auto extracted = std::make_shared<ExtractedFrame>();
  Stopwatch watch;
  extracted->frame = frame;
  cv::Mat grey;
  cv::cvtColor(frame.image, grey, cv::COLOR_BGR2GRAY);
  extracted->grey = EqualizeLuminance(grey, options_.equalization);
  extracted->equalization_milliseconds = watch.LapMilliseconds();
  extracted->feature_options.count = options_.feature_count;
  extracted->feature_options.threads = options_.threads;
  if (options_.features == FeatureSource::kSiftCorners ||
      options_.features == FeatureSource::kBoth) {
    if (!extracted->features().ok()) return extracted->features().status();
  }
  return std::shared_ptr<const ExtractedFrame>(std::move(extracted));
}

absl::Status FrameLabeller::Implementation::CheckOrder(const ExtractedFrame& frame) const {
  if (!history_.empty() && frame.frame.index <= history_.back()->frame.index) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame ", frame.frame.index, " came after frame ",
                     history_.back()->frame.index, "; indices must grow"));
  }
  return absl::OkStatus();
}

absl::Status FrameLabeller::Implementation::Push(std::shared_ptr<const ExtractedFrame> frame) {
  EGOSIEVE_RETURN_IF_ERROR(CheckOrder(*frame));
  if (!history_.empty() && history_.back()->grey.size() != frame->grey.size()) history_.clear();
  history_.push_back(std::move(frame));
  while (static_cast<int>(history_.size()) > options_.HistoryFrames()) history_.pop_front();
  return absl::OkStatus();
}

absl::Status FrameLabeller::Implementation::Restore(const std::vector<double>& state) {
  const bool valid = state.size() == kStateSize && state[0] == kStateVersion && state[1] >= 0 &&
                     std::isfinite(state[1]) && state[2] >= 0 && state[2] <= 1;
  if (!valid) {
    return absl::InvalidArgumentError(absl::StrCat("the labeller's state (", state.size(),
                                                   " numbers) is not one of this version"));
  }
  mixture_ = {state[1], state[2]};
  history_.clear();
  return absl::OkStatus();
}

absl::StatusOr<LabelledFrame> FrameLabeller::Implementation::Label(
    std::shared_ptr<const ExtractedFrame> frame) {
  if (frame == nullptr) return absl::InvalidArgumentError("no frame to label");
  EGOSIEVE_RETURN_IF_ERROR(CheckOrder(*frame));
  LabelledFrame result;
  result.frame_index = frame->frame.index;
  result.labelled = frame->frame;
  result.times.equalization_milliseconds = frame->equalization_milliseconds;
  if (!history_.empty() && history_.back()->grey.size() != frame->grey.size()) {
    const cv::Size before = history_.back()->grey.size(), now = frame->grey.size();
    SetOutcome(LabelOutcome::kSizeChanged,
               absl::StrCat("the frame is ", now.width, "x", now.height, ", those before it ",
                            before.width, "x", before.height),
               result);
  } else if (static_cast<int>(history_.size()) < std::max(options_.frame_gap, 1)) {
    SetOutcome(LabelOutcome::kNoPair,
               absl::StrCat("no frame ", options_.frame_gap, " before this one"), result);
  } else if (SamePixels(history_.back()->frame.image, frame->frame.image)) {
    SetOutcome(LabelOutcome::kDuplicateFrame, "the same picture as the frame before", result);
  } else {
    EGOSIEVE_RETURN_IF_ERROR(LabelPair(*Earlier(), *frame, result));
  }
  EGOSIEVE_RETURN_IF_ERROR(Push(std::move(frame)));
  return result;
}

absl::Status FrameLabeller::Implementation::LabelPair(const ExtractedFrame& first,
                                                      const ExtractedFrame& second,
                                                      LabelledFrame& result) {
  result.first_index = first.frame.index;
  result.second_index = second.frame.index;
  EGOSIEVE_ASSIGN_OR_RETURN(const FramePairs pairs, BuildPairs(first, second, options_));
  result.feature_count = pairs.feature_count;
  result.match_count = static_cast<int64_t>(pairs.labelled.size());
  result.times.features_milliseconds = pairs.features_milliseconds;
  result.times.matching_milliseconds = pairs.matching_milliseconds;
  if (result.feature_count < options_.minimum_matches) {
    SetOutcome(LabelOutcome::kTooFewFeatures,
               absl::StrCat("only ", result.feature_count, " features: no texture"), result);
    return absl::OkStatus();
  }
  const double share =
      static_cast<double>(pairs.match_count) / static_cast<double>(result.feature_count);
  if (pairs.match_count < options_.minimum_matches || share < kLeastMatchShare) {
    SetOutcome(LabelOutcome::kTooFewMatches,
               absl::StrCat("only ", pairs.match_count, " of ", result.feature_count,
                            " features have a match"),
               result);
    return absl::OkStatus();
  }
  Stopwatch watch;
  MotionModelOptions motion;
  motion.choice = options_.motion_model;
  motion.seed = MixSeed(options_.seed, static_cast<uint64_t>(second.frame.index), kGeometryStep);
  EGOSIEVE_ASSIGN_OR_RETURN(const MotionModel model, EstimateMotionModel(pairs.geometry, motion));
  result.times.geometry_milliseconds = watch.LapMilliseconds();
  result.motion_model = model.kind;
  result.motion_matrix = ToMatx(model.matrix);
  result.motion_trusted = model.trusted;
  result.parallax_pixels = model.parallax_pixels;
  result.inlier_count = model.inlier_count;
  if (!model.trusted) {
    SetOutcome(LabelOutcome::kUntrustedMotion, model.reason, result);
    return absl::OkStatus();
  }
  const bool on_first = options_.labelled_side == LabelledSide::kFirstFrame;
  GiveLabels(on_first ? first : second, pairs.labelled, model, result);
  result.times.labelling_milliseconds = watch.LapMilliseconds();
  return absl::OkStatus();
}

void FrameLabeller::Implementation::GiveLabels(const ExtractedFrame& labelled,
                                               const std::vector<PointPair>& pairs,
                                               const MotionModel& model, LabelledFrame& result) {
  const bool on_first = options_.labelled_side == LabelledSide::kFirstFrame;
  const bool paper = options_.label_rule == LabelRule::kScaledDistance;
  const std::vector<double> residuals =
      Residuals(model.kind, model.matrix, pairs,
                paper ? EpipolarDistance::kPointToLine : EpipolarDistance::kSampson);
  std::vector<double> distances = residuals;
  if (!paper) {
    std::vector<double> lengths;
    lengths.reserve(pairs.size());
    for (const PointPair& p : pairs) lengths.push_back(std::hypot(p.x2 - p.x1, p.y2 - p.y1));
    ReduceToShortFlow(lengths, options_.flow_noise_share, options_.noise_floor_pixels, distances);
  }
  result.noise_pixels = NoiseScale(distances, options_.noise_floor_pixels);
  std::vector<double> probability;
  switch (options_.label_rule) {
    case LabelRule::kScaledDistance:
      for (const double d : distances) probability.push_back(d / options_.paper_distance_pixels);
      break;
    case LabelRule::kScaledMedian:
      probability = ScaledMedianLabels(distances, result.noise_pixels, options_.median_multiple);
      break;
    case LabelRule::kMixture: {
      MixtureOptions mixture;
      mixture.residual_dimension = model.kind == MotionModelKind::kFundamental ? 1 : 2;
      mixture.noise_floor_pixels = options_.noise_floor_pixels;
      MixtureLabels labels = EstimateMixtureLabels(distances, mixture_, mixture);
      mixture_ = labels.state;
      result.noise_pixels = labels.state.noise_pixels;
      probability = std::move(labels.probability);
      break;
    }
  }
  result.labelled = labelled.frame;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const PointPair& p = pairs[i];
    const double x = on_first ? p.x1 : p.x2, y = on_first ? p.y1 : p.y2;
    if (!(probability[i] >= 0 && probability[i] <= 1) || !IsInside(x, y, labelled.grey.size())) {
      ++result.discarded_count;
      continue;
    }
    result.positions.insert(result.positions.end(), {x, y});
    result.other_positions.insert(result.other_positions.end(),
                                  {on_first ? p.x2 : p.x1, on_first ? p.y2 : p.y1});
    result.probability.push_back(probability[i]);
    result.residual_pixels.push_back(residuals[i]);
  }
  result.outcome = LabelOutcome::kLabelled;
}

FrameLabeller::FrameLabeller(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
FrameLabeller::~FrameLabeller() = default;

absl::StatusOr<std::unique_ptr<FrameLabeller>> FrameLabeller::Create(
    const FrameLabellerOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  return std::unique_ptr<FrameLabeller>(
      new FrameLabeller(std::make_unique<Implementation>(options)));
}

absl::StatusOr<LabelledFrame> FrameLabeller::Process(const Frame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::shared_ptr<const ExtractedFrame> extracted, Extract(frame));
  return Label(std::move(extracted));
}

absl::StatusOr<std::shared_ptr<const ExtractedFrame>> FrameLabeller::Extract(
    const Frame& frame) const {
  return implementation_->Extract(frame);
}

absl::StatusOr<LabelledFrame> FrameLabeller::Label(std::shared_ptr<const ExtractedFrame> frame) {
  return implementation_->Label(std::move(frame));
}

absl::Status FrameLabeller::Prime(const Frame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::shared_ptr<const ExtractedFrame> extracted, Extract(frame));
  return implementation_->Push(std::move(extracted));
}

std::vector<double> FrameLabeller::state() const { return implementation_->state(); }

absl::Status FrameLabeller::Restore(const std::vector<double>& state) {
  return implementation_->Restore(state);
}

const FrameLabellerOptions& FrameLabeller::options() const { return implementation_->options(); }

}  // namespace egosieve::vision
