#include "vision/masks/colour_model.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_format.h"

namespace egosieve::vision {
namespace {

constexpr int kSteps = 16;  // of a colour axis
constexpr int kColours = kSteps * kSteps * kSteps;
// Added to the shares, so that the evidence of a rarely seen colour is weak.
constexpr float kFloor = 2e-4f;

// v_i <- v_{i-1} / 4 + v_i / 2 + v_{i+1} / 4 along the axis whose steps lie `stride` apart; the
// ends are repeated.
void SmoothAxis(std::vector<float>& values, int stride) {
  for (int start = 0; start < kColours; start += kSteps * stride) {
    for (int offset = 0; offset < stride; ++offset) {
      float* line = values.data() + start + offset;
      float before = line[0];
      for (int i = 0; i < kSteps; ++i) {
        const float here = line[i * stride];
        const float behind = i + 1 < kSteps ? line[(i + 1) * stride] : here;
        line[i * stride] = 0.25f * (before + behind) + 0.5f * here;
        before = here;
      }
    }
  }
}

}  // namespace

absl::Status ColourModelOptions::Validate() const {
  if (support_pixels > 0.0 && limit > 0.0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "support_pixels = %g, limit = %g; both must be positive", support_pixels, limit));
}

cv::Mat1w ColourBins(const cv::Mat3b& image) {
  cv::Mat3b colours;
  cv::cvtColor(image, colours, cv::COLOR_BGR2Lab);
  cv::Mat1w bins(image.size());
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const cv::Vec3b& colour = colours(y, x);
      bins(y, x) = static_cast<uint16_t>(((colour[0] >> 4) * kSteps + (colour[1] >> 4)) * kSteps +
                                         (colour[2] >> 4));
    }
  }
  return bins;
}

ColourModel::ColourModel() : moving_(kColours, 0.0f), still_(kColours, 0.0f) {}

void ColourModel::Add(const cv::Mat1w& bins, const cv::Mat1f& probability) {
  for (int y = 0; y < bins.rows; ++y) {
    for (int x = 0; x < bins.cols; ++x) {
      const float p = probability(y, x), q = 1.0f - p;
      moving_[bins(y, x)] += p * p * p;
      still_[bins(y, x)] += q * q * q;
    }
  }
}

void ColourModel::Add(const ColourModel& other) {
  std::transform(moving_.begin(), moving_.end(), other.moving_.begin(), moving_.begin(),
                 std::plus<>());
  std::transform(still_.begin(), still_.end(), other.still_.begin(), still_.begin(), std::plus<>());
}

cv::Mat1f ColourModel::Evidence(const cv::Mat1w& bins, const ColourModelOptions& options) const {
  std::vector<float> moving = moving_, still = still_;
  for (std::vector<float>* values : {&moving, &still}) {
    for (int stride = 1; stride < kColours; stride *= kSteps) SmoothAxis(*values, stride);
  }
  const float all_moving = std::accumulate(moving.begin(), moving.end(), 0.0f);
  const float all_still = std::accumulate(still.begin(), still.end(), 0.0f);
  const float least = std::min(all_moving, all_still);
  const float known = least / (least + static_cast<float>(options.support_pixels));
  const auto limit = static_cast<float>(options.limit);
  std::vector<float> evidence_of(kColours);
  for (int bin = 0; bin < kColours; ++bin) {
    const float f = moving[bin] / std::max(all_moving, 1e-6f) + kFloor;
    const float g = still[bin] / std::max(all_still, 1e-6f) + kFloor;
    evidence_of[bin] = std::clamp(known * std::log(f / g), -limit, limit);
  }
  cv::Mat1f evidence(bins.size());
  for (int y = 0; y < bins.rows; ++y) {
    for (int x = 0; x < bins.cols; ++x) evidence(y, x) = evidence_of[bins(y, x)];
  }
  return evidence;
}

}  // namespace egosieve::vision
