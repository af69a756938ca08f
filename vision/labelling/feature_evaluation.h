// How well distances and labels tell movers from the rest, where the truth is known: the area under
// the ROC curve over labelled features.
//
//   AUC = P(score of a mover > score of another) + 1/2 P(equal)            (Mann & Whitney, 1947)
#ifndef EGOSIEVE_VISION_LABELLING_FEATURE_EVALUATION_H_
#define EGOSIEVE_VISION_LABELLING_FEATURE_EVALUATION_H_

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

// Nothing where one of the two kinds is missing. scores and is_mover are of one length, scores not
// NaN.
std::optional<double> AreaUnderRoc(const std::vector<double>& scores,
                                   const std::vector<bool>& is_mover);

struct FeatureScore {
  std::optional<double> residual_auc;  // of the motion model that was chosen
  std::optional<double> rejected_auc;  // of the one that was not, at the same places
  std::optional<double> label_auc;
  int64_t scored_count = 0;
  int64_t mover_count = 0;
};

// mask: CV_8UC1 of the labelled frame's size; 255 mover, 128 not scored, else static.
FeatureScore ScoreAgainstMask(const LabelledFrame& frame, const cv::Mat& mask);

// A scene point followed by hand: label 1 is static, 2 and more are moving objects.
struct LabelledTrack {
  int label = 1;
  std::map<int64_t, cv::Point2d> places;  // by frame number, pixels
};

// From "track,label,frame,x,y" lines below one header line; frame numbers less
// `first_frame_number`.
absl::StatusOr<std::vector<LabelledTrack>> ReadLabelledTracks(const std::string& path,
                                                              int64_t first_frame_number);

struct TrackPairs {
  std::vector<PointPair> pairs;
  std::vector<bool> is_mover;
};

// The tracks that are seen in both frames.
TrackPairs PairsOfTracks(const std::vector<LabelledTrack>& tracks, int64_t first, int64_t second);

// The motion model's residuals at the tracks rather than at the features. A track's label is that
// of the nearest labelled place, where one is within `label_radius_pixels`; others do not count in
// label_auc.
FeatureScore ScoreAgainstTracks(const LabelledFrame& frame,
                                const std::vector<LabelledTrack>& tracks,
                                double label_radius_pixels = 10.0);

// Whether the motion model that was chosen tells movers from the rest as well as the rejected one,
// by the truth. Differences in AUC up to kTiedAuc are of no weight and are counted apart.
enum class ChoiceVerdict { kBetter, kTied, kWorse };
inline constexpr double kTiedAuc = 0.01;

// Nothing where there was no choice or the truth has one kind only.
std::optional<ChoiceVerdict> JudgeChoice(const FeatureScore& score);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_FEATURE_EVALUATION_H_
