#include "tests/vision/labelling/feature_evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <sstream>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"
#include "vision/geometry/residual.h"

namespace egosieve::vision {
namespace {

constexpr int kMover = 255;
constexpr int kVoid = 128;

Eigen::Matrix3d ToEigen(const cv::Matx33d& m) {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result(i, j) = m(i, j);
  }
  return result;
}

std::vector<double> RejectedResiduals(const LabelledFrame& frame,
                                      const std::vector<PointPair>& pairs) {
  return Residuals(frame.rejected_model, ToEigen(frame.rejected_matrix), pairs,
                   EpipolarDistance::kSampson);
}

// The labelled place nearest to (x, y); -1 if none is within the radius.
int64_t NearestPlace(const LabelledFrame& frame, double x, double y, double radius) {
  int64_t nearest = -1;
  double least = radius * radius;
  for (int64_t i = 0; i < frame.size(); ++i) {
    const double dx = frame.positions[2 * i] - x, dy = frame.positions[2 * i + 1] - y;
    if (dx * dx + dy * dy > least) continue;
    least = dx * dx + dy * dy;
    nearest = i;
  }
  return nearest;
}

}  // namespace

std::optional<double> AreaUnderRoc(const std::vector<double>& scores,
                                   const std::vector<bool>& is_mover) {
  std::vector<size_t> order(scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scores[a] < scores[b]; });
  double movers = 0.0, others = 0.0, wins = 0.0;
  for (size_t begin = 0; begin < order.size();) {
    double tied_movers = 0.0, tied_others = 0.0;
    size_t end = begin;
    for (; end < order.size() && scores[order[end]] == scores[order[begin]]; ++end) {
      (is_mover[order[end]] ? tied_movers : tied_others) += 1.0;
    }
    wins += tied_movers * (others + 0.5 * tied_others);
    movers += tied_movers;
    others += tied_others;
    begin = end;
  }
  if (!(movers > 0.0 && others > 0.0)) return std::nullopt;
  return wins / (movers * others);
}

FeatureScore ScoreAgainstMask(const LabelledFrame& frame, const cv::Mat& mask) {
  const std::vector<double> all_rejected = RejectedResiduals(frame, PairsOf(frame));
  std::vector<double> residuals, rejected, labels;
  std::vector<bool> is_mover;
  for (int64_t i = 0; i < frame.size(); ++i) {
    const int x = static_cast<int>(std::lround(frame.positions[2 * i]));
    const int y = static_cast<int>(std::lround(frame.positions[2 * i + 1]));
    if (x < 0 || y < 0 || x >= mask.cols || y >= mask.rows) continue;
    const int truth = mask.at<uint8_t>(y, x);
    if (truth == kVoid) continue;
    is_mover.push_back(truth == kMover);
    residuals.push_back(frame.residual_pixels[i]);
    rejected.push_back(all_rejected[i]);
    labels.push_back(frame.probability[i]);
  }
  FeatureScore score;
  if (frame.rejected_model != MotionModelKind::kNone) {
    score.rejected_auc = AreaUnderRoc(rejected, is_mover);
  }
  score.residual_auc = AreaUnderRoc(residuals, is_mover);
  score.label_auc = AreaUnderRoc(labels, is_mover);
  score.scored_count = static_cast<int64_t>(is_mover.size());
  score.mover_count = std::count(is_mover.begin(), is_mover.end(), true);
  return score;
}

absl::StatusOr<std::vector<LabelledTrack>> ReadLabelledTracks(const std::string& path,
                                                              int64_t first_frame_number) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::string text, kernels::ReadFile(path));
  std::istringstream file(std::move(text));
  std::map<long, LabelledTrack> tracks;
  std::string line;
  std::getline(file, line);
  for (int number = 2; std::getline(file, line); ++number) {
    if (line.empty()) continue;
    long track = 0, frame = 0;
    int label = 0;
    double x = 0.0, y = 0.0;
    if (std::sscanf(line.c_str(), "%ld,%d,%ld,%lf,%lf", &track, &label, &frame, &x, &y) != 5) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ", line ", number, ": not `track,label,frame,x,y`"));
    }
    tracks[track].label = label;
    tracks[track].places[frame - first_frame_number] = {x, y};
  }
  std::vector<LabelledTrack> result;
  for (auto& [number, track] : tracks) result.push_back(std::move(track));
  return result;
}

TrackPairs PairsOfTracks(const std::vector<LabelledTrack>& tracks, int64_t first, int64_t second) {
  TrackPairs result;
  for (const LabelledTrack& track : tracks) {
    const auto a = track.places.find(first), b = track.places.find(second);
    if (a == track.places.end() || b == track.places.end()) continue;
    result.pairs.push_back({a->second.x, a->second.y, b->second.x, b->second.y});
    result.is_mover.push_back(track.label > 1);
  }
  return result;
}

FeatureScore ScoreAgainstTracks(const LabelledFrame& frame,
                                const std::vector<LabelledTrack>& tracks,
                                double label_radius_pixels) {
  const TrackPairs truth = PairsOfTracks(tracks, frame.first_index, frame.second_index);
  FeatureScore score;
  score.scored_count = static_cast<int64_t>(truth.pairs.size());
  score.mover_count = std::count(truth.is_mover.begin(), truth.is_mover.end(), true);
  if (frame.motion_model == MotionModelKind::kNone) return score;
  score.residual_auc = AreaUnderRoc(Residuals(frame.motion_model, ToEigen(frame.motion_matrix),
                                              truth.pairs, EpipolarDistance::kSampson),
                                    truth.is_mover);
  if (frame.rejected_model != MotionModelKind::kNone) {
    score.rejected_auc = AreaUnderRoc(RejectedResiduals(frame, truth.pairs), truth.is_mover);
  }
  const bool on_first = frame.labelled.index == frame.first_index;
  std::vector<double> labels;
  std::vector<bool> is_labelled_mover;
  for (size_t i = 0; i < truth.pairs.size(); ++i) {
    const PointPair& p = truth.pairs[i];
    const int64_t place =
        NearestPlace(frame, on_first ? p.x1 : p.x2, on_first ? p.y1 : p.y2, label_radius_pixels);
    if (place < 0) continue;
    labels.push_back(frame.probability[place]);
    is_labelled_mover.push_back(truth.is_mover[i]);
  }
  score.label_auc = AreaUnderRoc(labels, is_labelled_mover);
  return score;
}

std::optional<ChoiceVerdict> JudgeChoice(const FeatureScore& score) {
  if (!score.residual_auc.has_value() || !score.rejected_auc.has_value()) return std::nullopt;
  const double gain = *score.residual_auc - *score.rejected_auc;
  if (gain > kTiedAuc) return ChoiceVerdict::kBetter;
  return gain < -kTiedAuc ? ChoiceVerdict::kWorse : ChoiceVerdict::kTied;
}

}  // namespace egosieve::vision
