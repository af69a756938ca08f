#include "vision/masks/temporal_link.h"

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "kernels/base/parallel_for.h"

namespace egosieve::vision {
namespace {

struct Sums {
  cv::Mat1f weighted;  // N
  cv::Mat1f weight;    // D
};

Sums OwnSums(const LinkFrame& frame) {
  if (!frame.has_map) {
    return {cv::Mat1f::zeros(frame.log_odds.size()), cv::Mat1f::zeros(frame.log_odds.size())};
  }
  return {frame.log_odds.clone(), cv::Mat1f(frame.log_odds.size(), 1.0f)};
}

// (from + returned)^2; `back` is sampled where `from` leads.
cv::Mat1f ReturnError(const cv::Mat& from, const cv::Mat& back) {
  const cv::Mat returned = WarpByFlow(back, from);
  cv::Mat1f errors(from.size());
  for (int y = 0; y < from.rows; ++y) {
    const cv::Vec2f* there = from.ptr<cv::Vec2f>(y);
    const cv::Vec2f* again = returned.ptr<cv::Vec2f>(y);
    for (int x = 0; x < from.cols; ++x) {
      const cv::Vec2f error = there[x] + again[x];
      errors(y, x) = error.dot(error);
    }
  }
  return errors;
}

// Adds the sums of a neighbour, sampled along `flow`, which starts at this frame.
void TakeOver(const Sums& neighbour, const cv::Mat& flow, const cv::Mat1f& errors, double seconds,
              const TemporalLinkOptions& options, Sums& sums) {
  if (flow.empty()) return;
  // Merged, so that one pass of sampling serves both.
  cv::Mat2f neighbours;
  cv::merge(std::array<cv::Mat, 2>{neighbour.weighted, neighbour.weight}, neighbours);
  std::array<cv::Mat, 2> seen;
  cv::split(WarpByFlow(neighbours, flow), seen);
  cv::Mat1f factor = AgreementOf(errors, kTolerancePixels);
  factor *= std::exp(-std::abs(seconds) / options.memory_seconds);
  sums.weighted += factor.mul(seen[0]);
  sums.weight += factor.mul(seen[1]);
}

std::vector<Sums> GatherPast(const std::vector<LinkFrame>& frames,
                             const TemporalLinkOptions& options) {
  std::vector<Sums> all;
  for (size_t t = 0; t < frames.size(); ++t) {
    Sums sums = OwnSums(frames[t]);
    if (t > 0) {
      TakeOver(all.back(), frames[t].flow.backward, frames[t].errors.backward,
               frames[t].time_seconds - frames[t - 1].time_seconds, options, sums);
    }
    all.push_back(std::move(sums));
  }
  return all;
}

std::vector<Sums> GatherFuture(const std::vector<LinkFrame>& frames,
                               const TemporalLinkOptions& options) {
  std::vector<Sums> all(frames.size());
  for (size_t t = frames.size(); t-- > 0;) {
    all[t] = OwnSums(frames[t]);
    if (t + 1 < frames.size()) {
      TakeOver(all[t + 1], frames[t + 1].flow.forward, frames[t + 1].errors.forward,
               frames[t + 1].time_seconds - frames[t].time_seconds, options, all[t]);
    }
  }
  return all;
}

}  // namespace

cv::Mat1f AgreementOf(const cv::Mat1f& errors, double tolerance_pixels) {
  const auto scale = static_cast<float>(-0.5 / (tolerance_pixels * tolerance_pixels));
  cv::Mat1f agreement = errors * scale;
  cv::exp(agreement, agreement);
  return agreement;
}

ReturnErrors ReturnErrorsOf(const FlowPair& flow) {
  if (flow.forward.empty()) return {};
  return {ReturnError(flow.forward, flow.backward), ReturnError(flow.backward, flow.forward)};
}

std::vector<cv::Mat1f> LinkMaps(const std::vector<LinkFrame>& frames,
                                const TemporalLinkOptions& options) {
  std::vector<Sums> past, future;
  kernels::ParallelFor(options.causal ? 1 : 2, [&](int64_t side) {
    if (side == 0) {
      past = GatherPast(frames, options);
    } else {
      future = GatherFuture(frames, options);
    }
  });
  // Smaller weights count as this: they are of a memory that has faded over ten times its length.
  constexpr float kLeastWeight = 5e-5f;
  std::vector<cv::Mat1f> linked;
  for (size_t t = 0; t < frames.size(); ++t) {
    cv::Mat1f weighted = past[t].weighted, weight = past[t].weight;
    if (!options.causal) {
      const Sums own = OwnSums(frames[t]);
      weighted = weighted + future[t].weighted - own.weighted;
      weight = weight + future[t].weight - own.weight;
    }
    cv::Mat1f mean;
    cv::divide(weighted, cv::max(weight, kLeastWeight), mean);
    linked.push_back(mean);
  }
  return linked;
}

}  // namespace egosieve::vision
