#include "tools/evaluation/identity.h"

#include <array>
#include <cmath>

#include "tools/evaluation/assignment.h"

namespace egosieve::tools {
namespace {

constexpr int kThresholds = 19;
// Tolerance for rounding when similarities are compared with thresholds; as in TrackEval.
constexpr double kSlack = 2.2e-16;

double ThresholdAt(int step) { return 0.05 * (step + 1); }

// The index of the track with this number; adds the track if it is new.
int TrackOf(int number, std::map<int, int>& tracks, std::vector<int64_t>& frames) {
  const auto [place, is_new] = tracks.try_emplace(number, static_cast<int>(tracks.size()));
  if (is_new) frames.push_back(0);
  return place->second;
}

struct Areas {
  std::map<int, int64_t> truth, predicted, ignored;  // ignored: of predicted objects
  std::map<std::pair<int, int>, int64_t> common;
};

Areas MeasureAreas(const cv::Mat1i& truth, const cv::Mat1i& predicted, const cv::Mat1b& void_pixels,
                   int min_area) {
  std::map<int, int64_t> whole;
  for (const int number : truth) ++whole[number];
  Areas areas;
  for (int y = 0; y < truth.rows; ++y) {
    for (int x = 0; x < truth.cols; ++x) {
      const int real = truth(y, x), called = predicted(y, x);
      const bool is_ignored =
          (!void_pixels.empty() && void_pixels(y, x) != 0) || (real != 0 && whole[real] < min_area);
      if (called != 0) {
        ++areas.predicted[called];
        if (is_ignored) ++areas.ignored[called];
      }
      if (real == 0 || is_ignored) continue;
      ++areas.truth[real];
      if (called != 0) ++areas.common[{real, called}];
    }
  }
  return areas;
}

}  // namespace

void IdentityScorer::Add(const cv::Mat1i& truth, const cv::Mat1i& predicted,
                         const cv::Mat1b& void_pixels) {
  const Areas areas = MeasureAreas(truth, predicted, void_pixels, min_area_);
  Frame frame;
  std::vector<int> real, called;  // numbers of the objects
  for (const auto& [number, area] : areas.truth) {
    real.push_back(number);
    frame.truth.push_back(TrackOf(number, truth_tracks_, truth_frames_));
    ++truth_frames_[frame.truth.back()];
  }
  for (const auto& [number, area] : areas.predicted) {
    const auto ignored = areas.ignored.find(number);
    if (ignored != areas.ignored.end() && 2 * ignored->second > area) continue;
    called.push_back(number);
    frame.predicted.push_back(TrackOf(number, predicted_tracks_, predicted_frames_));
    ++predicted_frames_[frame.predicted.back()];
  }
  frame.similarity =
      cv::Mat1d::zeros(static_cast<int>(real.size()), static_cast<int>(called.size()));
  for (size_t i = 0; i < real.size(); ++i) {
    for (size_t j = 0; j < called.size(); ++j) {
      const auto common = areas.common.find({real[i], called[j]});
      if (common == areas.common.end()) continue;
      const int64_t both = areas.truth.at(real[i]) + areas.predicted.at(called[j]) - common->second;
      frame.similarity(static_cast<int>(i), static_cast<int>(j)) =
          static_cast<double>(common->second) / static_cast<double>(both);
    }
  }
  frames_.push_back(std::move(frame));
}

int64_t IdentityScorer::IdentityTruePositives() const {
  cv::Mat1d matches = cv::Mat1d::zeros(static_cast<int>(truth_frames_.size()),
                                       static_cast<int>(predicted_frames_.size()));
  for (const Frame& frame : frames_) {
    for (int i = 0; i < frame.similarity.rows; ++i) {
      for (int j = 0; j < frame.similarity.cols; ++j) {
        if (frame.similarity(i, j) >= 0.5) ++matches(frame.truth[i], frame.predicted[j]);
      }
    }
  }
  const std::vector<int> partners = AssignLargest(matches);
  double sum = 0.0;
  for (int i = 0; i < matches.rows; ++i) {
    if (partners[i] >= 0) sum += matches(i, partners[i]);
  }
  return std::llround(sum);
}

cv::Mat1d IdentityScorer::GlobalAlignment() const {
  cv::Mat1d together = cv::Mat1d::zeros(static_cast<int>(truth_frames_.size()),
                                        static_cast<int>(predicted_frames_.size()));
  for (const Frame& frame : frames_) {
    if (frame.similarity.empty()) continue;
    cv::Mat1d rows, columns;
    cv::reduce(frame.similarity, rows, 1, cv::REDUCE_SUM);
    cv::reduce(frame.similarity, columns, 0, cv::REDUCE_SUM);
    for (int i = 0; i < frame.similarity.rows; ++i) {
      for (int j = 0; j < frame.similarity.cols; ++j) {
        const double s = frame.similarity(i, j);
        if (s > 0.0) together(frame.truth[i], frame.predicted[j]) += s / (rows(i) + columns(j) - s);
      }
    }
  }
  for (int i = 0; i < together.rows; ++i) {
    for (int j = 0; j < together.cols; ++j) {
      const double m = together(i, j);
      together(i, j) = m / (static_cast<double>(truth_frames_[i] + predicted_frames_[j]) - m);
    }
  }
  return together;
}

std::optional<IdentityScores> IdentityScorer::Score() const {
  IdentityScores scores;
  for (const Frame& frame : frames_) {
    scores.truth_objects += static_cast<int64_t>(frame.truth.size());
    scores.predicted_objects += static_cast<int64_t>(frame.predicted.size());
  }
  const int64_t objects = scores.truth_objects + scores.predicted_objects;
  if (objects == 0) return std::nullopt;
  scores.idf1 = 2.0 * static_cast<double>(IdentityTruePositives()) / static_cast<double>(objects);
  const cv::Mat1d alignment = GlobalAlignment();
  std::array<std::map<std::pair<int, int>, int64_t>, kThresholds> pairs;
  std::array<int64_t, kThresholds> true_positives = {};
  for (const Frame& frame : frames_) {
    cv::Mat1d weighed = frame.similarity.clone();
    for (int i = 0; i < weighed.rows; ++i) {
      for (int j = 0; j < weighed.cols; ++j) {
        weighed(i, j) *= alignment(frame.truth[i], frame.predicted[j]);
      }
    }
    const std::vector<int> partners = AssignLargest(weighed);
    for (int i = 0; i < weighed.rows; ++i) {
      if (partners[i] < 0) continue;
      for (int step = 0; step < kThresholds; ++step) {
        if (frame.similarity(i, partners[i]) < ThresholdAt(step) - kSlack) break;
        ++true_positives[step];
        ++pairs[step][{frame.truth[i], frame.predicted[partners[i]]}];
      }
    }
  }
  for (int step = 0; step < kThresholds; ++step) {
    const auto found = static_cast<double>(true_positives[step]);
    if (found == 0.0) continue;
    double association = 0.0;
    for (const auto& [tracks, count] : pairs[step]) {
      const auto c = static_cast<double>(count);
      const int64_t all = truth_frames_[tracks.first] + predicted_frames_[tracks.second];
      association += c * c / (static_cast<double>(all) - c);
    }
    association /= found;
    const double detection = found / (static_cast<double>(objects) - found);
    scores.detection += detection / kThresholds;
    scores.association += association / kThresholds;
    scores.hota += std::sqrt(detection * association) / kThresholds;
  }
  return scores;
}

}  // namespace egosieve::tools
