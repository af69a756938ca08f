#include "vision/masks/map_window.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "absl/strings/str_format.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "vision/features/flow_growth.h"
#include "vision/matching/scene_agreement.h"

namespace egosieve::vision {
namespace {

// Weights of the temporal link are below a fiftieth at this distance.
constexpr double kReachInMemories = 4.0;
constexpr int kLeastFlowSide = 16;

bool ShowOneScene(const FlowPair& flow, const cv::Mat1b& first, const cv::Mat1b& second) {
  const TrackedGrid grid = TrackGrid(flow, first, second, true, {});
  SceneAgreement scene(second.size());
  for (size_t i = 0; i < grid.textured.size(); ++i) {
    scene.AddFlow(grid.textured[i], grid.agrees[i] != 0);
  }
  return scene.IsOneScene();
}

// The first and the last of the frames whose colours are used for frame t.
std::pair<size_t, size_t> ColourRange(const std::vector<WindowFrame>& frames, size_t t,
                                      const MapWindowOptions& options) {
  const auto is_near = [&](size_t s) {
    return std::abs(frames[s].time_seconds - frames[t].time_seconds) <= options.colour_seconds;
  };
  size_t first = t, last = t;
  while (first > 0 && !frames[first].flow.forward.empty() && is_near(first - 1)) --first;
  while (!options.link.causal && last + 1 < frames.size() &&
         !frames[last + 1].flow.forward.empty() && is_near(last + 1)) {
    ++last;
  }
  return {first, last};
}

// linked + colour of every frame.
std::vector<cv::Mat1f> JoinColours(const std::vector<WindowFrame>& frames,
                                   const MapWindowOptions& options) {
  std::vector<LinkFrame> links;
  for (const WindowFrame& frame : frames) {
    links.push_back({frame.time_seconds, frame.log_odds, frame.has_map, frame.flow, frame.errors});
  }
  std::vector<cv::Mat1f> joined = LinkMaps(links, options.link);
  std::vector<ColourModel> colours(frames.size());
  const auto all = static_cast<int64_t>(frames.size());
  kernels::ParallelFor(all,
                       [&](int64_t i) { colours[i].Add(frames[i].bins, Probability(joined[i])); });
  kernels::ParallelFor(all, [&](int64_t t) {
    ColourModel around;
    const auto [from, to] = ColourRange(frames, t, options);
    for (size_t s = from; s <= to; ++s) around.Add(colours[s]);
    joined[t] += around.Evidence(frames[t].bins, options.colour);
  });
  return joined;
}

}  // namespace

absl::Status MapWindowOptions::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(link.Validate());
  EGOSIEVE_RETURN_IF_ERROR(colour.Validate());
  EGOSIEVE_RETURN_IF_ERROR(edges.Validate());
  if (colour_seconds >= 0.0 && steady_seconds > 0.0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("colour_seconds = %g, steady_seconds = %g; the first must not be negative, "
                      "the second must be positive",
                      colour_seconds, steady_seconds));
}

double MapWindowOptions::ReachSeconds() const {
  return std::max(kReachInMemories * link.memory_seconds, colour_seconds);
}

WindowFrame MakeWindowFrame(double time_seconds, const cv::Mat3b& image,
                            const cv::Mat1f& probability, bool has_map) {
  const int step = WorkingStep(image.size());
  WindowFrame frame;
  frame.time_seconds = time_seconds;
  frame.image = image;
  frame.small = ToWorkingSize(image, step);
  frame.bins = ColourBins(frame.small);
  frame.log_odds = LogOdds(ToWorkingSize(probability, step));
  frame.has_map = has_map;
  return frame;
}

absl::Status LinkFrames(std::vector<WindowFrame>& frames) {
  std::vector<absl::Status> statuses(frames.size(), absl::OkStatus());
  kernels::ParallelFor(static_cast<int64_t>(frames.size()) - 1, [&](int64_t i) {
    const WindowFrame& before = frames[i];
    WindowFrame& now = frames[i + 1];
    const bool is_linkable = before.small.size() == now.small.size() &&
                             std::min(now.small.rows, now.small.cols) >= kLeastFlowSide;
    if (now.is_linked || !is_linkable) return;
    now.is_linked = true;
    cv::Mat1b first, second;
    cv::cvtColor(before.small, first, cv::COLOR_BGR2GRAY);
    cv::cvtColor(now.small, second, cv::COLOR_BGR2GRAY);
    absl::StatusOr<FlowPair> flow = ComputeFlow(first, second, FlowQuality::kMedium);
    statuses[i] = flow.status();
    if (!flow.ok()) return;
    const FlowPair estimated = {flow->forward.clone(), flow->backward.clone()};
    GrowFlow(first, second, {}, *flow);
    if (!ShowOneScene(*flow, first, second)) return;
    now.flow = *std::move(flow);
    now.estimated = estimated;
    now.errors = ReturnErrorsOf(now.flow);
  });
  for (const absl::Status& status : statuses) EGOSIEVE_RETURN_IF_ERROR(status);
  return absl::OkStatus();
}

std::vector<cv::Mat1f> RefineWindow(const std::vector<WindowFrame>& frames, int first, int count,
                                    const MapWindowOptions& options) {
  const std::vector<cv::Mat1f> joined = JoinColours(frames, options);
  const auto all = static_cast<int64_t>(frames.size());
  std::vector<cv::Mat1f> sharp(frames.size());
  kernels::ParallelFor(all, [&](int64_t i) {
    sharp[i] = LogOdds(RefineProbability(frames[i].small, joined[i], options.edges));
  });
  TemporalLinkOptions steady = options.link;
  steady.memory_seconds = options.steady_seconds;
  std::vector<LinkFrame> links;
  for (size_t t = 0; t < frames.size(); ++t) {
    links.push_back({frames[t].time_seconds, sharp[t], true, frames[t].flow, frames[t].errors});
  }
  const std::vector<cv::Mat1f> linked = LinkMaps(links, steady);
  std::vector<cv::Mat1f> refined(count);
  kernels::ParallelFor(count, [&](int64_t k) {
    const size_t t = first + k;
    const cv::Mat3b& image = frames[t].image;
    cv::Mat1f shift;
    cv::resize(linked[t] - sharp[t], shift, image.size(), 0, 0, cv::INTER_LINEAR);
    refined[k] = Probability(LogOdds(RefineProbability(image, joined[t], options.edges)) + shift);
  });
  return refined;
}

}  // namespace egosieve::vision
