#include "vision/features/flow_growth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "kernels/base/parallel_for.h"
#include "vision/features/flow_patch.h"
#include "vision/features/patch_search.h"
#include "vision/image/node_grid.h"

namespace egosieve::vision {
namespace {

constexpr float kHolds = 0.7f, kAccepted = kLeastCorrelation, kSettled = 0.9f;  // of c, (PC2)
constexpr float kGain = 0.5f;
constexpr int kMostSteps = 5;                            // of an alignment
constexpr double kMostReturn = 0.25;                     // pixels
constexpr double kAlikeFloor = 1.0, kAlikeSlope = 0.05;  // of displacements, pixels
constexpr int kMostSweeps = 12;

struct Place {
  cv::Point2f at, displacement;
  std::unique_ptr<FlowPatch> patch;  // of a textured place that is not settled
  float correlation = -1.0f;
  bool is_textured = false, holds = false, corrected = false;
};

// A point that may take over a neighbour's displacement.
struct Candidate {
  int place;
  cv::Point2f displacement;
};

class Growth {
 public:
  Growth(const FlowPicture& from, const FlowPicture& to, const FlowGridOptions& options)
      : from_(from), to_(to), options_(options) {
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
        if (!from_.HoldsPatch(FlowPatchCorner(place.at))) continue;
        auto patch = std::make_unique<FlowPatch>(from_, FlowPatchCorner(place.at));
        place.is_textured = patch->norm() >= kTextureLevels * kFlowPatchSide;
        place.displacement = SampleField(there, place.at);
        place.correlation = CorrelationAt(*patch, place.at + place.displacement);
        place.holds = FollowFlow(there, back, place.at).has_value() &&
                      (!place.is_textured || place.correlation >= kHolds);
        const bool is_settled = place.holds && place.correlation >= kSettled;
        if (place.is_textured && !is_settled) place.patch = std::move(patch);
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
      Correct(place, *found[k] - place.at, CorrelationAt(*place.patch, *found[k]));
    }
  }

  // -1 where the patch leaves the picture.
  float CorrelationAt(const FlowPatch& patch, cv::Point2f centre) const {
    const cv::Point2f corner = FlowPatchCorner(centre);
    return to_.HoldsPatch(corner) ? patch.Correlation(to_, corner) : -1.0f;
  }

  static void Correct(Place& place, cv::Point2f displacement, float correlation) {
    place.displacement = displacement;
    place.correlation = correlation;
    place.holds = place.corrected = true;
    if (correlation >= kSettled) place.patch.reset();
  }

  // For every unsettled neighbour of a fresh point, the displacement that fits it best.
  std::vector<Candidate> Offer(const std::vector<int>& fresh) const {
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
          if (place.patch == nullptr) continue;
          if (place.holds && AreAlike(place.displacement, displacement)) continue;
          const float correlation = CorrelationAt(*place.patch, place.at + displacement);
          if (!best[i] || correlation > best[i]->correlation) best[i] = {correlation, displacement};
        }
      }
    }
    std::vector<Candidate> candidates;
    for (size_t i = 0; i < best.size(); ++i) {
      if (best[i]) candidates.push_back({static_cast<int>(i), best[i]->displacement});
    }
    return candidates;
  }

  static bool AreAlike(cv::Point2f a, cv::Point2f b) {
    return cv::norm(a - b) <= kAlikeFloor + kAlikeSlope * cv::norm(b);
  }

  // Corrects candidates and returns those that were corrected.
  std::vector<int> Accept(const std::vector<Candidate>& candidates) {
    std::vector<uint8_t> is_accepted(candidates.size(), 0);
    kernels::ParallelFor(static_cast<int64_t>(candidates.size()), [&](int64_t k) {
      const Candidate& candidate = candidates[k];
      Place& place = places_[candidate.place];
      const cv::Point2f corner = FlowPatchCorner(place.at);
      const auto [there, match] =
          place.patch->Align(to_, corner + candidate.displacement, kMostSteps);
      const cv::Point2f displacement = there - corner;
      if (!to_.HoldsPatch(there) || !AreAlike(displacement, candidate.displacement)) return;
      const float correlation = place.patch->Correlation(match);
      const bool gains = !place.holds || 1.0f - correlation <= kGain * (1.0f - place.correlation);
      if (correlation < kAccepted || !gains) return;
      const cv::Point2f back = FlowPatch(to_, there).Align(from_, corner, kMostSteps).corner;
      if (cv::norm(back - corner) > kMostReturn) return;
      Correct(place, displacement, correlation);
      is_accepted[k] = 1;
    });
    std::vector<int> accepted;
    for (size_t k = 0; k < candidates.size(); ++k) {
      if (is_accepted[k] != 0) accepted.push_back(candidates[k].place);
    }
    return accepted;
  }

  const FlowPicture& from_;
  const FlowPicture& to_;
  const FlowGridOptions& options_;
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
  std::array<std::optional<FlowPicture>, 2> pictures;
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
