#include "vision/own_vehicle/windscreen.h"

#include <cstddef>
#include <opencv2/imgproc.hpp>

#include "vision/own_vehicle/mount_shake.h"

namespace egosieve::vision {
namespace {

constexpr double kRecurringShare = 0.2, kProvenShare = 0.1;
constexpr int kFewestProven = 10;  // pixels of a patch
constexpr int kReach = 13;         // pixels: a window and one on each side

// 255 where M has contrast and enough pictures agree with it.
cv::Mat1b Recurring(const FixedPlaces& places, const FixedPattern& pattern) {
  cv::Mat1i agreeing = cv::Mat1i::zeros(places.kind.size());
  for (const cv::Mat1b& picture : places.agreeing) cv::add(agreeing, 1, agreeing, picture);
  const auto count = static_cast<double>(places.agreeing.size());
  return (agreeing >= kRecurringShare * count) &
         (pattern.variance() >= kLeastContrast * kLeastContrast);
}

// The connected patches of `candidates` with a large enough share of proven pixels.
cv::Mat1b ProvenPatches(const cv::Mat1b& candidates, const cv::Mat1b& proven) {
  cv::Mat1i patch;
  const int count = cv::connectedComponents(candidates, patch, 8, CV_32S);
  std::vector<int> area(count, 0), proven_area(count, 0);
  for (int y = 0; y < patch.rows; ++y) {
    for (int x = 0; x < patch.cols; ++x) {
      ++area[patch(y, x)];
      proven_area[patch(y, x)] += proven(y, x) != 0;
    }
  }
  cv::Mat1b found = cv::Mat1b::zeros(candidates.size());
  for (int y = 0; y < patch.rows; ++y) {
    for (int x = 0; x < patch.cols; ++x) {
      const int p = patch(y, x);
      if (p == 0 || proven_area[p] < kFewestProven) continue;
      if (proven_area[p] >= kProvenShare * area[p]) found(y, x) = 255;
    }
  }
  return found;
}

}  // namespace

cv::Mat1b FindWindscreen(const FixedPlaces& places, const std::vector<cv::Mat1b>& seconds,
                         const std::vector<PairWorld>& worlds, const Pinhole& camera) {
  if (places.agreeing.empty()) return {};
  cv::Mat1f median;
  places.median.convertTo(median, CV_32F);
  const FixedPattern pattern(median);
  std::vector<cv::Mat1b> both_agree;
  for (size_t k = 0; k < seconds.size(); ++k) {
    cv::Mat1f second = SmoothPicture(seconds[k]);
    if (!places.shakes.empty()) {
      cv::Matx23f shake = places.shakes[k];
      second = Steady(median, second, shake);
    }
    both_agree.push_back(places.agreeing[k] & pattern.Agreeing(second));
  }
  const cv::Mat1b candidates = Recurring(places, pattern);
  const cv::Mat1b proven = ProvenPlaces(candidates, places, worlds, camera, &both_agree);
  cv::Mat1b mixed = ProvenPatches(candidates, proven);
  cv::dilate(mixed, mixed, cv::Mat1b::ones(kReach, kReach));
  if (!places.shakes.empty()) mixed = Shaken(mixed, places.shakes);
  return OfTheImage(mixed, places.image);
}

}  // namespace egosieve::vision
