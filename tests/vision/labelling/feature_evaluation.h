// Scores residuals and labels against ground truth: the area under the ROC curve, movers against
// static points, over labelled features.
//
//   AUC = P(score of a mover > score of another) + 1/2 P(equal)            (Mann & Whitney, 1947)
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/point_pair.h"
#include "vision/labelling/labelled_frame.h"

namespace egosieve::vision {

// nullopt if one of the two classes is empty. scores and is_mover have the same length; scores must
// not be NaN.
std::optional<double> AreaUnderRoc(const std::vector<double>& scores,
                                   const std::vector<bool>& is_mover);

struct FeatureScore {
  std::optional<double> residual_auc;  // of the selected motion model
  std::optional<double> rejected_auc;  // of the rejected one, at the same places
  std::optional<double> label_auc;
  int64_t scored_count = 0;
  int64_t mover_count = 0;
};

// mask: CV_8UC1 of the labelled frame's size; 255 mover, 128 not scored, else static.
FeatureScore ScoreAgainstMask(const LabelledFrame& frame, const cv::Mat& mask);

// A scene point tracked by hand: label 1 is static, 2 and more are moving objects.
struct LabelledTrack {
  int label = 1;
  std::map<int64_t, cv::Point2d> places;  // by frame number, pixels
};

// Reads lines "track,label,frame,x,y" below one header line. `first_frame_number` is subtracted
// from the frame numbers.
absl::StatusOr<std::vector<LabelledTrack>> ReadLabelledTracks(const std::string& path,
                                                              int64_t first_frame_number);

struct TrackPairs {
  std::vector<PointPair> pairs;
  std::vector<bool> is_mover;
};

// The tracks with a place in both frames.
TrackPairs PairsOfTracks(const std::vector<LabelledTrack>& tracks, int64_t first, int64_t second);

// Scores the motion model's residuals at the tracks instead of the features. A track's label is
// that of the nearest labelled place within `label_radius_pixels`; tracks without one do not count
// in label_auc.
FeatureScore ScoreAgainstTracks(const LabelledFrame& frame,
                                const std::vector<LabelledTrack>& tracks,
                                double label_radius_pixels = 10.0);

// Whether the selected motion model separates movers from static points better than the rejected
// one, by ground truth. Differences in AUC up to kTiedAuc count as a tie.
enum class ChoiceVerdict { kBetter, kTied, kWorse };
inline constexpr double kTiedAuc = 0.01;

// nullopt if there was no rejected model or the ground truth has one class only.
std::optional<ChoiceVerdict> JudgeChoice(const FeatureScore& score);

}  // namespace egosieve::vision
