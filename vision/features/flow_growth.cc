#include "vision/features/flow_growth.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <optional>
#include <vector>

#include "kernels/base/parallel_for.h"
#include "vision/features/patch_search.h"
#include "vision/image/node_grid.h"

namespace egosieve::vision {
namespace {

constexpr float kHolds = 0.7f, kAccepted = 0.85f, kSettled = 0.9f;  // of c (FG1)
constexpr float kGain = 0.5f;
constexpr int kSide = 8, kArea = kSide * kSide, kBefore = 3;  // of a patch, pixels
constexpr int kWindow = 9;                                    // of Lucas-Kanade, pixels
constexpr double kMostReturn = 0.5;                           // pixels
constexpr double kAlikeFloor = 1.0, kAlikeSlope = 0.05;       // of displacements, pixels
constexpr int kMostSweeps = 12;

using Row = Eigen::Array<float, kSide, 1>;  // of a patch

struct Patch {
  std::array<Row, kSide> levels;  // about their mean
  float norm = 0.0f;              // root of their sum of squares
};

// The patch at a position; nothing where it leaves the picture. Bilinear with one weight for all
// pixels of a patch, row by row, which the compiler vectorises.
std::optional<Patch> PatchAt(const cv::Mat& picture, cv::Point2f place) {
  const float left = place.x - kBefore, top = place.y - kBefore;
  if (!(left >= 0 && top >= 0 && left < picture.cols - kSide && top < picture.rows - kSide)) {
    return std::nullopt;
  }
  const int x = static_cast<int>(left), y = static_cast<int>(top);
  const float fx = left - x, fy = top - y;
  const float a = (1 - fy) * (1 - fx), b = (1 - fy) * fx, c = fy * (1 - fx), d = fy * fx;
  const auto pixels = [&](int row, int column) -> Row {
    using Bytes = Eigen::Map<const Eigen::Array<uint8_t, kSide, 1>>;
    return Bytes(picture.ptr<uint8_t>(y + row) + x + column).cast<float>();
  };
  Patch patch;
  Row sum = Row::Zero(), squares = Row::Zero();
  for (int v = 0; v < kSide; ++v) {
    patch.levels[v] =
        a * pixels(v, 0) + b * pixels(v, 1) + c * pixels(v + 1, 0) + d * pixels(v + 1, 1);
    sum += patch.levels[v];
  }
  const float mean = sum.sum() / kArea;
  for (Row& row : patch.levels) {
    row -= mean;
    squares += row * row;
  }
  patch.norm = std::sqrt(squares.sum());
  return patch;
}

float Correlation(const Patch& a, const Patch& b) {
  Row sum = Row::Zero();
  for (int v = 0; v < kSide; ++v) sum += a.levels[v] * b.levels[v];
  const float norms = a.norm * b.norm;
  return norms > 0.0f ? sum.sum() / norms : 0.0f;
}

struct Place {
  cv::Point2f at, displacement;
  Patch patch;
  float correlation = -1.0f;
  bool is_textured = false, holds = false, corrected = false;
};

// Points that may take over a neighbour's displacement.
struct Candidates {
  std::vector<int> places;
  std::vector<cv::Point2f> starts, displacements;
};

// A picture with its gradients in the form used by Lucas-Kanade.
struct Picture {
  const cv::Mat& grey;
  std::vector<cv::Mat> gradients;

  explicit Picture(const cv::Mat& picture) : grey(picture) {
    cv::buildOpticalFlowPyramid(grey, gradients, cv::Size(kWindow, kWindow), 0);
  }
};

class Growth {
 public:
  Growth(const Picture& from, const Picture& to, const FlowGridOptions& options)
      : from_(from.grey),
        to_(to.grey),
        options_(options),
        from_gradients_(from.gradients),
        to_gradients_(to.gradients) {
    const cv::Size nodes = NodesOf(from_.size(), options.stride_pixels);
    columns_ = nodes.width;
    rows_ = nodes.height;
  }

  std::vector<Place> Run(const cv::Mat& there, const cv::Mat& back) {
    Measure(there, back);
    Seed();
    std::vector<int> fresh;
    for (int i = 0; i < static_cast<int>(places_.size()); ++i) {
      if (places_[i].holds && places_[i].is_textured) fresh.push_back(i);
    }
    for (int sweep = 0; sweep < kMostSweeps && !fresh.empty(); ++sweep) {
      fresh = Accept(Offer(fresh));
    }
    return std::move(places_);
  }

 private:
  void Measure(const cv::Mat& there, const cv::Mat& back) {
    places_.resize(static_cast<size_t>(columns_) * rows_);
    kernels::ParallelFor(rows_, [&](int64_t row) {
      for (int column = 0; column < columns_; ++column) {
        Place& place = places_[row * columns_ + column];
        place.at = PlaceOfNode({column, static_cast<int>(row)}, options_.stride_pixels);
        const auto patch = PatchAt(from_, place.at);
        if (!patch) continue;
        place.patch = *patch;
        place.is_textured = patch->norm >= options_.texture_levels * kSide;
        place.displacement = SampleField(there, place.at);
        const auto other = PatchAt(to_, place.at + place.displacement);
        if (other) place.correlation = Correlation(place.patch, *other);
        place.holds = FollowFlow(there, back, place.at, options_).has_value() &&
                      (!place.is_textured || place.correlation >= kHolds);
      }
    });
  }

  // Searches for a fourth of the points; growth reaches those between.
  void Seed() {
    std::vector<int> owners;
    std::vector<cv::Point2f> starts;
    for (int row = 0; row < rows_; row += 2) {
      for (int column = 0; column < columns_; column += 2) {
        const Place& place = places_[row * columns_ + column];
        if (place.holds || !place.is_textured) continue;
        owners.push_back(row * columns_ + column);
        starts.push_back(place.at);
      }
    }
    const auto found = SearchPatches(from_, to_, starts, 2 * options_.stride_pixels);
    for (size_t k = 0; k < owners.size(); ++k) {
      if (!found[k]) continue;
      Place& place = places_[owners[k]];
      const auto other = PatchAt(to_, *found[k]);
      const float correlation = other ? Correlation(place.patch, *other) : -1.0f;
      if (correlation < kAccepted) continue;
      Correct(place, *found[k] - place.at, correlation);
    }
  }

  static void Correct(Place& place, cv::Point2f displacement, float correlation) {
    place.displacement = displacement;
    place.correlation = correlation;
    place.holds = place.corrected = true;
  }

  // For every unsettled neighbour of a fresh point, the displacement that fits it best.
  Candidates Offer(const std::vector<int>& fresh) const {
    struct Best {
      float correlation;
      cv::Point2f displacement;
    };
    std::vector<std::optional<Best>> best(places_.size());
    for (const int from : fresh) {
      const int row = from / columns_, column = from % columns_;
      const cv::Point2f displacement = places_[from].displacement;
      for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
        for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x) {
          const int i = y * columns_ + x;
          const Place& place = places_[i];
          if (!place.is_textured || (place.holds && place.correlation >= kSettled)) continue;
          if (place.holds && AreAlike(place.displacement, displacement)) continue;
          const auto other = PatchAt(to_, place.at + displacement);
          if (!other) continue;
          const float correlation = Correlation(place.patch, *other);
          if (!best[i] || correlation > best[i]->correlation) best[i] = {correlation, displacement};
        }
      }
    }
    Candidates candidates;
    for (size_t i = 0; i < best.size(); ++i) {
      if (!best[i]) continue;
      candidates.places.push_back(static_cast<int>(i));
      candidates.starts.push_back(places_[i].at);
      candidates.displacements.push_back(best[i]->displacement);
    }
    return candidates;
  }

  static bool AreAlike(cv::Point2f a, cv::Point2f b) {
    return cv::norm(a - b) <= kAlikeFloor + kAlikeSlope * cv::norm(b);
  }

  // Corrects candidates and returns those that were corrected.
  std::vector<int> Accept(const Candidates& candidates) {
    std::vector<int> accepted;
    if (candidates.places.empty()) return accepted;
    std::vector<cv::Point2f> ends = candidates.starts, back = candidates.starts;
    for (size_t k = 0; k < ends.size(); ++k) ends[k] += candidates.displacements[k];
    std::vector<uint8_t> is_there, is_back;
    const cv::Size window(kWindow, kWindow);
    const cv::TermCriteria criteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 8, 0.03);
    cv::calcOpticalFlowPyrLK(from_gradients_, to_gradients_, candidates.starts, ends, is_there,
                             cv::noArray(), window, 0, criteria, cv::OPTFLOW_USE_INITIAL_FLOW);
    cv::calcOpticalFlowPyrLK(to_gradients_, from_gradients_, ends, back, is_back, cv::noArray(),
                             window, 0, criteria, cv::OPTFLOW_USE_INITIAL_FLOW);
    for (size_t k = 0; k < ends.size(); ++k) {
      Place& place = places_[candidates.places[k]];
      const cv::Point2f displacement = ends[k] - place.at;
      if (is_there[k] == 0 || is_back[k] == 0 || cv::norm(back[k] - place.at) > kMostReturn ||
          !AreAlike(displacement, candidates.displacements[k])) {
        continue;
      }
      const auto other = PatchAt(to_, ends[k]);
      if (!other) continue;
      const float correlation = Correlation(place.patch, *other);
      const bool gains = !place.holds || 1.0f - correlation <= kGain * (1.0f - place.correlation);
      if (correlation < kAccepted || !gains) continue;
      Correct(place, displacement, correlation);
      accepted.push_back(candidates.places[k]);
    }
    return accepted;
  }

  const cv::Mat& from_;
  const cv::Mat& to_;
  const FlowGridOptions& options_;
  const std::vector<cv::Mat>& from_gradients_;
  const std::vector<cv::Mat>& to_gradients_;
  int columns_ = 0, rows_ = 0;
  std::vector<Place> places_;
};

void Fill(cv::Mat& field, cv::Point2f centre, int side, cv::Point2f displacement) {
  const cv::Rect square(static_cast<int>(std::lround(centre.x)) - side / 2,
                        static_cast<int>(std::lround(centre.y)) - side / 2, side, side);
  const cv::Rect inside = square & cv::Rect(0, 0, field.cols, field.rows);
  if (!inside.empty()) field(inside).setTo(cv::Scalar(displacement.x, displacement.y));
}

}  // namespace

int64_t GrowFlow(const cv::Mat& first, const cv::Mat& second, const FlowGridOptions& options,
                 FlowPair& flow) {
  std::array<std::optional<Picture>, 2> pictures;
  kernels::ParallelFor(2, [&](int64_t k) { pictures[k].emplace(k == 0 ? first : second); });
  std::array<std::vector<Place>, 2> places;
  kernels::ParallelFor(2, [&](int64_t direction) {
    const cv::Mat& there = direction == 0 ? flow.forward : flow.backward;
    const cv::Mat& back = direction == 0 ? flow.backward : flow.forward;
    places[direction] =
        Growth(*pictures[direction], *pictures[1 - direction], options).Run(there, back);
  });
  // A match corrects both fields. The field in which a point lies is filled last.
  int64_t count = 0;
  for (const bool own : {false, true}) {
    for (int direction = 0; direction < 2; ++direction) {
      cv::Mat& field = (direction == 0) == own ? flow.forward : flow.backward;
      for (const Place& place : places[direction]) {
        if (!place.corrected) continue;
        count += own;
        Fill(field, own ? place.at : place.at + place.displacement, options.stride_pixels,
             own ? place.displacement : -place.displacement);
      }
    }
  }
  return count;
}

}  // namespace egosieve::vision
