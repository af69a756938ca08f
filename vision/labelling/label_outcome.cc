#include "vision/labelling/label_outcome.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/equalization.h"
#include "vision/frame/repeated_picture.h"
#include "vision/image/inside.h"
#include "vision/labelling/reduced_labels.h"
#include "vision/labelling/stopwatch.h"

namespace egosieve::vision {
namespace {

constexpr double kMajority = 0.5;

}  // namespace

FrameLabellerOptions FrameLabellerOptions::Paper() {
  FrameLabellerOptions options;
  options.is_paper = true;
  options.equalization = Equalization::kGlobal;
  return options;
}

absl::Status FrameLabellerOptions::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(kernels::CheckOptions({
      {"longest_side_pixels", longest_side_pixels,
       longest_side_pixels == 0 || longest_side_pixels >= 64, "be at least 64, or 0"},
      {"frame_gap", frame_gap, frame_gap >= 0 && frame_gap <= 100,
       "be from 1 to 100, or 0 for auto"},
  }));
  if (is_paper && frame_gap == 0) {
    return absl::InvalidArgumentError("the paper's front end needs a frame_gap of at least 1");
  }
  return absl::OkStatus();
}

absl::StatusOr<LabelledFrame> FrameLabeller::Process(const Frame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::shared_ptr<const ExtractedFrame> extracted, Extract(frame));
  return Label(std::move(extracted));
}

absl::Status MakeGrey(const Frame& frame, const FrameLabellerOptions& options,
                      ExtractedFrame& extracted) {
  if (frame.image.empty() || frame.image.type() != CV_8UC3) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame ", frame.index, ": the image is empty or not 8-bit BGR"));
  }
  Stopwatch watch;
  extracted.frame = frame;
  extracted.grey = EqualizedGrey(
      ReducePicture(Corrected(frame.image, options.lens.get()), options.longest_side_pixels),
      options.equalization);
  extracted.equalization_milliseconds = watch.LapMilliseconds();
  return absl::OkStatus();
}

void ToPixelsOfFrame(const ExtractedFrame& frame, const LensCorrection* lens,
                     LabelledFrame& labels) {
  const cv::Size size = frame.frame.image.size();
  EnlargeLabels(frame.grey.size(), size, labels);
  if (lens == nullptr || lens->size() != size) return;
  const auto distort = [&](std::vector<double>& places) {
    for (size_t i = 0; i + 1 < places.size(); i += 2) {
      const cv::Point2d place = lens->Distort({places[i], places[i + 1]});
      places[i] = place.x;
      places[i + 1] = place.y;
    }
  };
  distort(labels.positions);
  distort(labels.other_positions);
  std::vector<size_t> inside;
  for (size_t i = 0; i < labels.probability.size(); ++i) {
    if (IsInside(labels.positions[2 * i], labels.positions[2 * i + 1], size)) inside.push_back(i);
  }
  const auto keep = [&](auto& values, size_t each) {
    if (values.empty()) return;
    for (size_t k = 0; k < inside.size(); ++k) {
      std::copy_n(values.begin() + static_cast<int64_t>(each * inside[k]), each,
                  values.begin() + static_cast<int64_t>(each * k));
    }
    values.resize(each * inside.size());
  };
  keep(labels.positions, 2);
  keep(labels.other_positions, 2);
  keep(labels.probability, 1);
  keep(labels.decided_by, 1);
}

absl::Status CheckOrder(const ExtractedFrame* last, const ExtractedFrame& frame) {
  if (last != nullptr && frame.frame.index <= last->frame.index) {
    return absl::InvalidArgumentError(absl::StrCat("frame ", frame.frame.index,
                                                   " came after frame ", last->frame.index,
                                                   "; indices must grow"));
  }
  return absl::OkStatus();
}

LabelledFrame BeginLabels(const ExtractedFrame& frame) {
  LabelledFrame result;
  result.frame_index = frame.frame.index;
  result.labelled = frame.frame;
  result.milliseconds.equalization = frame.equalization_milliseconds;
  return result;
}

void SetNoPair(int frame_gap, LabelledFrame& result) {
  SetOutcome(LabelOutcome::kNoPair,
             frame_gap > 1 ? absl::StrCat("fewer than ", frame_gap, " frames before this one")
                           : "no frame before this one",
             result);
}

bool HasOtherSize(const ExtractedFrame& last, const ExtractedFrame& frame, LabelledFrame& result) {
  const cv::Size before = last.frame.image.size(), now = frame.frame.image.size();
  if (before == now) return false;
  SetOutcome(LabelOutcome::kSizeChanged,
             absl::StrCat("the frame is ", now.width, "x", now.height, ", those before it ",
                          before.width, "x", before.height),
             result);
  return true;
}

bool IsRepeated(const ExtractedFrame& last, const ExtractedFrame& frame, LabelledFrame& result) {
  if (!SamePixels(last.frame.image, frame.frame.image)) return false;
  SetOutcome(LabelOutcome::kDuplicateFrame, "the same picture as the frame before", result);
  return true;
}

bool IsEnough(const PairCounts& counts, LabelledFrame& result) {
  constexpr int kFewest = FrameLabellerOptions::kFewestMatches;
  result.feature_count = counts.features;
  result.match_count = counts.labelled;
  if (result.feature_count < kFewest) {
    SetOutcome(LabelOutcome::kTooFewFeatures,
               absl::StrCat("only ", result.feature_count, " features: no texture"), result);
    return false;
  }
  const bool enough = counts.matches >= kFewest;
  if (enough && counts.scene.IsOneScene()) return true;
  const SceneAgreement::Areas areas = counts.scene.CountAreas();
  SetOutcome(LabelOutcome::kTooFewMatches,
             enough ? absl::StrFormat("another scene: %d of %d areas agree with the frame before",
                                      areas.holding, areas.judged)
                    : absl::StrFormat("only %d of %d features have a match", counts.matches,
                                      counts.features),
             result);
  return false;
}

void SetOutcome(LabelOutcome outcome, std::string reason, LabelledFrame& result) {
  result.outcome = outcome;
  result.reason = std::move(reason);
}

std::string DoubtOf(const LabelledFrame& labels) {
  if (labels.outcome == LabelOutcome::kDuplicateFrame) return "";
  if (labels.outcome != LabelOutcome::kLabelled) return labels.reason;
  if (labels.static_share < kMajority) {
    return absl::StrFormat("only %.0f %% of the image points agree on how the camera moved",
                           100.0 * labels.static_share);
  }
  const auto moving =
      static_cast<double>(std::count_if(labels.probability.begin(), labels.probability.end(),
                                        [](double probability) { return probability >= 0.5; }));
  const double share = moving / static_cast<double>(std::max<int64_t>(labels.size(), 1));
  if (share > kMajority) {
    return absl::StrFormat("%.0f %% of the labelled places seem to move", 100.0 * share);
  }
  return "";
}

std::string DoubtOfTurn(const TwoViewMotion& motion, const Pinhole& camera, cv::Size size) {
  // Of focal lengths where nothing is known, one deviation (bundle_adjustment.h).
  constexpr double kFactor = 1.5;
  constexpr double kMostBend = 3.0;  // deviations of a place, which would seem to move
  const double turn = std::acos(std::clamp(motion.rotation(2, 2), -1.0, 1.0));
  const double border = 0.5 * std::max(size.width, size.height) / camera.focal_pixels;
  const double bend = camera.focal_pixels * turn * border * border * (kFactor * kFactor - 1.0);
  return bend > kMostBend * motion.noise_pixels
             ? "the camera turns, and its focal length is not known yet"
             : "";
}

}  // namespace egosieve::vision
