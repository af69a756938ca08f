// Points of a regular grid, tracked by dense inverse-search flow (DIS; Kroeger et al., 2016).
//
//   f = flow from first to second, b = flow from second to first
//   x2 = x1 + f(x1),   e(x1) = | f(x1) + b(x2) |                     forward-backward error
//   kept where e < kErrorFloor + kErrorSlope |f(x1)| and x2 lies in the image
//
// Flow is smooth and dense. It gives a displacement, consistent in both directions, even for a
// blank wall. So for each point the pictures are compared as well. With P the patch of 7 x 7 pixels
// around it and Q the patch of the other picture, sampled along the flow,
//
//   textured   std P >= kTextureLevels
//   agrees     sum (P - mean P)(Q - mean Q) >= kAgreement |P - mean P| |Q - mean Q|
//
// Textured points whose correlation is below kContradiction are dropped. Points without texture
// are kept and marked, since the flow around them may well be theirs. Lost textured points are
// searched for (flow_growth.h) if that is requested.
//
// Fields and pictures are sampled bilinearly. Cost: two flows, linear in the pixels.
#pragma once

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// kMedium works at half resolution with patches 3 pixels apart, kFast at a quarter with patches 2
// apart, kUltrafast there with patches 4 apart and without refinement.
enum class FlowQuality { kUltrafast, kFast, kMedium };

struct FlowGridOptions {
  int stride_pixels = 5;  // of the grid; positive
  FlowQuality quality = FlowQuality::kFast;
  bool searches_lost = false;  // apply flow_growth.h after ComputeFlow
  // Mask of the area without grid points, see ignored_area.h.
  cv::Mat1b ignored;
};

inline constexpr double kTextureLevels = 3.0;  // of 255

struct FlowPair {
  cv::Mat forward;   // CV_32FC2, pixels, first to second
  cv::Mat backward;  // second to first
};

// Grey CV_8UC1 images of one size, at least 16 pixels in each direction.
absl::StatusOr<FlowPair> ComputeFlow(const cv::Mat& first, const cv::Mat& second,
                                     FlowQuality quality);

// The share of a grid's textured points that flow must follow for it to be valid between two
// pictures.
inline constexpr double kFlowSuffices = 0.35;

struct TrackedGrid {
  std::vector<PointPair> pairs;      // row by row of the grid
  std::vector<uint8_t> is_textured;  // one per pair
  // All textured points of the grid, and for each whether flow agrees and is kept.
  std::vector<cv::Point2f> textured;
  std::vector<uint8_t> agrees;

  int64_t AgreeingCount() const { return std::count(agrees.begin(), agrees.end(), 1); }
};

// The grid lies in the second image (`anchor_second`) or in the first, at whole pixels there. The
// images must be those from which the flow was computed.
TrackedGrid TrackGrid(const FlowPair& flow, const cv::Mat& first, const cv::Mat& second,
                      bool anchor_second, const FlowGridOptions& options);

// Whether ComputeFlow accepts images of this size.
bool IsLargeEnoughForFlow(cv::Size size);

// The position to which a flow moves `from`; nothing if it leaves the picture or does not return.
std::optional<cv::Point2f> FollowFlow(const cv::Mat& there, const cv::Mat& back, cv::Point2f from);

// Samples a picture or a field at x + flow(x), bilinearly; outside, at the nearest border pixel.
cv::Mat WarpByFlow(const cv::Mat& values, const cv::Mat& flow);

// Bilinear sample of a CV_32FC2 field, clamped at the border.
cv::Point2f SampleField(const cv::Mat& field, cv::Point2f at);

}  // namespace egosieve::vision
