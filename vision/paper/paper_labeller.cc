#include "vision/paper/paper_labeller.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/ignored_area.h"
#include "vision/frame/repeated_picture.h"
#include "vision/image/inside.h"
#include "vision/labelling/label_outcome.h"
#include "vision/labelling/reduced_labels.h"
#include "vision/labelling/stopwatch.h"
#include "vision/paper/feature_extractor.h"
#include "vision/paper/feature_matcher.h"
#include "vision/paper/fundamental_fit.h"
#include "vision/paper/neighbour_agreement.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {

struct PaperFrame : ExtractedFrame {
  FeatureSet features;
  double features_milliseconds = 0.0;
};

namespace {

constexpr uint64_t kGeometryStep = 1;
constexpr double kLargestDistance = 3.0;  // pixels, of a plausible match
constexpr double kNoiseFloor = 0.2;       // pixels
constexpr char kState[] = "egalpap1";

// Matches outside of the ignored area as pairs of places. Counts features, matches and scenes.
std::vector<PointPair> MatchPlaces(const PaperFrame& first, const PaperFrame& second,
                                   const FrameLabellerOptions& options, PairCounts& counts) {
  const FeatureSet &a = first.features, &b = second.features;
  const std::vector<cv::DMatch> matches = MatchFeatures(a, b);
  std::vector<PointPair> places, kept;
  for (const cv::DMatch& match : matches) {
    const cv::Point2f p = a.positions[match.queryIdx], q = b.positions[match.trainIdx];
    places.push_back({p.x, p.y, q.x, q.y});
  }
  const std::vector<uint8_t> agrees = AgreesWithNeighbours(places);
  std::vector<uint8_t> is_found(b.size(), 0);
  for (size_t i = 0; i < matches.size(); ++i) is_found[matches[i].trainIdx] = agrees[i];
  for (int64_t i = 0; i < b.size(); ++i) {
    counts.scene.AddFeature(b.positions[i], is_found[i] != 0);
  }
  counts.features = b.size();
  counts.matches = static_cast<int64_t>(matches.size());
  std::copy_if(places.begin(), places.end(), std::back_inserter(kept), [&](const PointPair& pair) {
    return !IsIgnored(options.ignored, second.grey.size(), pair.x2, pair.y2);
  });
  counts.labelled = static_cast<int64_t>(kept.size());
  return kept;
}

// Step 5.
void LabelByDistance(const PaperFrame& first, const std::vector<PointPair>& pairs,
                     const MotionModel& model, LabelledFrame& result) {
  std::vector<double> distances;
  for (const PointPair& pair : pairs) distances.push_back(PointToLineDistance(model.matrix, pair));
  result.noise_pixels = RobustScale(distances, kNoiseFloor);
  result.labelled = first.frame;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const PointPair& p = pairs[i];
    const double probability = distances[i] / kLargestDistance;
    if (!(probability >= 0 && probability <= 1) || !IsInside(p.x1, p.y1, first.grey.size())) {
      ++result.discarded_count;
      continue;
    }
    result.positions.insert(result.positions.end(), {p.x1, p.y1});
    result.other_positions.insert(result.other_positions.end(), {p.x2, p.y2});
    result.probability.push_back(probability);
    result.decided_by.push_back(EvidenceTerm::kEpipolar);
  }
  result.outcome = LabelOutcome::kLabelled;
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameLabeller>> PaperLabeller::Create(
    const FrameLabellerOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  FrameLabellerOptions reduced = options;
  reduced.ignored = ReduceMask(options.ignored, options.longest_side_pixels);
  return std::unique_ptr<FrameLabeller>(new PaperLabeller(reduced));
}

absl::StatusOr<std::shared_ptr<const ExtractedFrame>> PaperLabeller::Extract(
    const Frame& frame) const {
  auto extracted = std::make_shared<PaperFrame>();
  EGOSIEVE_RETURN_IF_ERROR(MakeGrey(frame, options_, *extracted));
  Stopwatch watch;
  EGOSIEVE_ASSIGN_OR_RETURN(extracted->features, ExtractFeatures(extracted->grey));
  extracted->features_milliseconds = watch.LapMilliseconds();
  return extracted;
}

absl::StatusOr<LabelledFrame> PaperLabeller::Label(
    std::shared_ptr<const ExtractedFrame> extracted,
    const std::vector<std::shared_ptr<const ExtractedFrame>>& /*ahead*/) {
  if (extracted == nullptr) return absl::InvalidArgumentError("no frame to label");
  auto frame = std::static_pointer_cast<const PaperFrame>(std::move(extracted));
  const PaperFrame* last = history_.empty() ? nullptr : history_.back().get();
  EGOSIEVE_RETURN_IF_ERROR(CheckOrder(last, *frame));
  LabelledFrame result = BeginLabels(*frame);
  const cv::Size now = frame->frame.image.size();
  if (last != nullptr && HasOtherSize(*last, *frame, result)) {
    // The frame is the first of its size.
  } else if (last != nullptr && IsRepeated(*last, *frame, result)) {
    // Pairs are of different pictures.
  } else if (static_cast<int>(history_.size()) < options_.frame_gap) {
    SetNoPair(options_.frame_gap, result);
  } else {
    EGOSIEVE_RETURN_IF_ERROR(LabelPair(*history_.front(), *frame, result));
  }
  result.doubt = DoubtOf(result);
  EnlargeLabels(frame->grey.size(), now, result);
  Remember(std::move(frame), options_.frame_gap, history_);
  return result;
}

absl::Status PaperLabeller::LabelPair(const PaperFrame& first, const PaperFrame& second,
                                      LabelledFrame& result) const {
  result.first_index = first.frame.index;
  result.second_index = second.frame.index;
  Stopwatch watch;
  PairCounts counts(second.grey.size());
  const std::vector<PointPair> pairs = MatchPlaces(first, second, options_, counts);
  result.milliseconds.features = second.features_milliseconds;
  result.milliseconds.matching = watch.LapMilliseconds();
  if (!IsEnough(counts, result)) return absl::OkStatus();
  const uint64_t seed =
      MixSeed(options_.seed, static_cast<uint64_t>(second.frame.index), kGeometryStep);
  const MotionModel model = FitFundamental(pairs, seed);
  result.milliseconds.geometry = watch.LapMilliseconds();
  result.motion_model = model.kind;
  result.inlier_count = model.inlier_count;
  if (model.trusted) {
    LabelByDistance(first, pairs, model, result);
  } else {
    SetOutcome(LabelOutcome::kUntrustedMotion, model.reason, result);
  }
  result.milliseconds.labelling = watch.LapMilliseconds();
  return absl::OkStatus();
}

absl::Status PaperLabeller::Prime(const Frame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const ExtractedFrame> extracted, Extract(frame));
  EGOSIEVE_RETURN_IF_ERROR(
      CheckOrder(history_.empty() ? nullptr : history_.back().get(), *extracted));
  Remember(std::static_pointer_cast<const PaperFrame>(extracted), options_.frame_gap, history_);
  return absl::OkStatus();
}

std::string PaperLabeller::state() const { return kState; }

absl::Status PaperLabeller::Restore(absl::string_view state) {
  if (state != kState) {
    return absl::InvalidArgumentError(
        absl::StrCat("the labeller's state (", state.size(), " bytes) is not one of this version"));
  }
  history_.clear();
  return absl::OkStatus();
}

}  // namespace egosieve::vision
