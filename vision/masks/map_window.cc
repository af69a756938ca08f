#include "vision/masks/map_window.h"

#include <algorithm>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "vision/features/flow_growth.h"
#include "vision/matching/one_scene.h"

namespace egosieve::vision {
namespace {

// Weights of the temporal link are below a fiftieth at this distance.
constexpr double kReachInMemories = 4.0;
constexpr int kLeastFlowSide = 16;
constexpr size_t kCausalFrames = 8;

// Frames begin to end - 1.
struct FrameSpan {
  size_t begin = 0, end = 0;
};

// The frames that those of `wanted` are linked with by the second link.
FrameSpan SteadySpan(const std::vector<WindowFrame>& frames, FrameSpan wanted,
                     const MapWindowOptions& options) {
  const double reach = kReachInMemories * options.steady_seconds;
  const double first = frames[wanted.begin].time_seconds;
  const double last = frames[wanted.end - 1].time_seconds;
  FrameSpan span = wanted;
  while (span.begin > 0 && first - frames[span.begin - 1].time_seconds <= reach) --span.begin;
  while (!options.link.causal && span.end < frames.size() &&
         frames[span.end].time_seconds - last <= reach) {
    ++span.end;
  }
  return span;
}

// (SS3) of the frames of `span`, which is of one shot.
std::vector<cv::Mat1f> SegmentSpan(const std::vector<WindowFrame>& frames,
                                   const std::vector<cv::Mat1f>& linked, FrameSpan span,
                                   const MapWindowOptions& options) {
  std::vector<LinkFrame> shot(frames.begin() + span.begin, frames.begin() + span.end);
  for (size_t i = 0; i < shot.size(); ++i) shot[i].log_odds = linked[span.begin + i];
  return SegmentShot(shot, options.shot);
}

// (SS3) of the frames of `span`, shot by shot; where the link is causal, each from itself and the
// kCausalFrames before it.
std::vector<cv::Mat1f> SegmentShots(const std::vector<WindowFrame>& frames,
                                    const std::vector<cv::Mat1f>& linked, FrameSpan span,
                                    const MapWindowOptions& options) {
  std::vector<cv::Mat1f> joined;
  for (size_t begin = span.begin, end = begin; begin < span.end; begin = end) {
    end = begin + 1;
    while (end < span.end && !frames[end].flow.forward.empty()) ++end;
    if (!options.link.causal) {
      std::ranges::move(SegmentSpan(frames, linked, {begin, end}, options),
                        std::back_inserter(joined));
      continue;
    }
    for (size_t t = begin; t < end; ++t) {
      const size_t from = t - std::min(t - begin, kCausalFrames);
      joined.push_back(SegmentSpan(frames, linked, {from, t + 1}, options).back());
    }
  }
  return joined;
}

}  // namespace

double MapWindowOptions::ReachSeconds() const {
  return kReachInMemories * (link.memory_seconds + steady_seconds);
}

WindowFrame MakeWindowFrame(double time_seconds, const cv::Mat3b& image,
                            const cv::Mat1f& probability, bool has_map) {
  const int step = WorkingStep(image.size());
  WindowFrame frame;
  frame.time_seconds = time_seconds;
  frame.full = image;
  frame.image = ToWorkingSize(image, step);
  frame.log_odds = LogOdds(ToWorkingSize(probability, step));
  frame.has_map = has_map;
  return frame;
}

absl::Status LinkFrames(std::vector<WindowFrame>& frames) {
  std::vector<absl::Status> statuses(frames.size(), absl::OkStatus());
  kernels::ParallelFor(static_cast<int64_t>(frames.size()) - 1, [&](int64_t i) {
    const WindowFrame& before = frames[i];
    WindowFrame& now = frames[i + 1];
    const bool is_linkable = before.image.size() == now.image.size() &&
                             std::min(now.image.rows, now.image.cols) >= kLeastFlowSide;
    if (now.is_linked || !is_linkable) return;
    now.is_linked = true;
    cv::Mat1b first, second;
    cv::cvtColor(before.image, first, cv::COLOR_BGR2GRAY);
    cv::cvtColor(now.image, second, cv::COLOR_BGR2GRAY);
    absl::StatusOr<FlowPair> flow = ComputeFlow(first, second, FlowQuality::kMedium);
    statuses[i] = flow.status();
    if (!flow.ok()) return;
    GrowFlow(first, second, {}, *flow);
    if (!ShowOneScene(*flow, first, second)) return;
    now.flow = *std::move(flow);
    now.errors = ReturnErrorsOf(now.flow);
  });
  for (const absl::Status& status : statuses) EGOSIEVE_RETURN_IF_ERROR(status);
  return absl::OkStatus();
}

std::vector<cv::Mat1f> RefineWindow(const std::vector<WindowFrame>& frames, int first, int count,
                                    const MapWindowOptions& options) {
  const FrameSpan wanted{static_cast<size_t>(first), static_cast<size_t>(first + count)};
  const FrameSpan span = SteadySpan(frames, wanted, options);
  std::vector<LinkFrame> links(frames.begin(), frames.end());
  const std::vector<cv::Mat1f> joined =
      SegmentShots(frames, LinkMaps(links, options.link), span, options);
  links = {frames.begin() + span.begin, frames.begin() + span.end};
  for (size_t i = 0; i < joined.size(); ++i) {
    links[i].log_odds = joined[i];
    links[i].has_map = true;
  }
  TemporalLinkOptions steady_link = options.link;
  steady_link.memory_seconds = options.steady_seconds;
  const std::vector<cv::Mat1f> steady = LinkMaps(links, steady_link);
  std::vector<cv::Mat1f> refined(count);
  kernels::ParallelFor(count, [&](int64_t k) {
    refined[k] =
        RefineProbability(frames[wanted.begin + k].full, steady[wanted.begin - span.begin + k]);
  });
  return refined;
}

}  // namespace egosieve::vision
