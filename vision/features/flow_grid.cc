#include "vision/features/flow_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "absl/strings/str_cat.h"
#include "kernels/base/parallel_for.h"
#include "vision/features/inverse_search.h"
#include "vision/frame/ignored_area.h"
#include "vision/image/bilinear.h"
#include "vision/image/inside.h"
#include "vision/image/node_grid.h"

namespace egosieve::vision {
namespace {

constexpr int kMinimumSide = 16;
constexpr double kErrorFloor = 1.0, kErrorSlope = 0.02;   // the former in pixels
constexpr double kAgreement = 0.5, kContradiction = 0.2;  // of correlations

InverseSearchOptions SearchOptionsOf(FlowQuality quality) {
  switch (quality) {
    case FlowQuality::kUltrafast:
      return {.finest_level = 2, .patch_stride = 4, .refinements = 0};
    case FlowQuality::kFast:
      return {.finest_level = 2, .patch_stride = 2};
    case FlowQuality::kMedium:
      break;
  }
  return {};
}

// Compares patches of a picture with those of another, warped onto it by a flow.
class PatchComparison {
 public:
  struct Result {
    double deviation = 0.0;    // of the picture's patch, grey levels
    double correlation = 0.0;  // normalised; 0 where either patch is flat
  };

  PatchComparison(const cv::Mat& picture, const cv::Mat& other, const cv::Mat& flow)
      : picture_(picture), warped_(WarpByFlow(other, flow)) {}

  Result At(int x, int y) const {
    const int left = std::max(x - kRadius, 0), right = std::min(x + kRadius, picture_.cols - 1);
    const int top = std::max(y - kRadius, 0), bottom = std::min(y + kRadius, picture_.rows - 1);
    int a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (int row = top; row <= bottom; ++row) {
      const uint8_t* p = picture_.ptr<uint8_t>(row);
      const uint8_t* q = warped_.ptr<uint8_t>(row);
      for (int column = left; column <= right; ++column) {
        const int u = p[column], v = q[column];
        a += u;
        b += v;
        aa += u * u;
        bb += v * v;
        ab += u * v;
      }
    }
    // n times the sums of squares and products about the means: whole numbers.
    const int64_t n = int64_t{right - left + 1} * (bottom - top + 1);
    const double squares_a = static_cast<double>(n * aa - int64_t{a} * a);
    const double squares_b = static_cast<double>(n * bb - int64_t{b} * b);
    Result result;
    result.deviation = std::sqrt(squares_a) / static_cast<double>(n);
    if (squares_a > 0.0 && squares_b > 0.0) {
      result.correlation =
          static_cast<double>(n * ab - int64_t{a} * b) / std::sqrt(squares_a * squares_b);
    }
    return result;
  }

 private:
  static constexpr int kRadius = 3;
  const cv::Mat& picture_;
  cv::Mat warped_;
};

// The pair of a node of the grid and its position in the other picture, in the order of the images.
PointPair PairOf(cv::Point2f node, cv::Point2f there, bool anchor_second) {
  return anchor_second ? PointPair{there.x, there.y, node.x, node.y}
                       : PointPair{node.x, node.y, there.x, there.y};
}

struct Node {
  cv::Point2f place;
  bool textured = false, agrees = false;
  std::optional<cv::Point2f> there = std::nullopt;  // in the other picture
};

}  // namespace

absl::StatusOr<FlowPair> ComputeFlow(const cv::Mat& first, const cv::Mat& second,
                                     FlowQuality quality) {
  if (first.size() != second.size() || first.type() != CV_8UC1 || second.type() != CV_8UC1) {
    return absl::InvalidArgumentError("flow needs two grey 8-bit images of one size");
  }
  if (!IsLargeEnoughForFlow(first.size())) {
    return absl::InvalidArgumentError(
        absl::StrCat("flow needs images of at least ", kMinimumSide, " pixels in each direction"));
  }
  const InverseSearchOptions options = SearchOptionsOf(quality);
  FlowPair flow;
  try {
    std::array<std::optional<SearchPyramid>, 2> pyramids;
    kernels::ParallelFor(
        2, [&](int64_t k) { pyramids[k].emplace(k == 0 ? first : second, options.finest_level); });
    kernels::ParallelFor(2, [&](int64_t direction) {
      cv::Mat& field = direction == 0 ? flow.forward : flow.backward;
      field = SearchFlow(*pyramids[direction], *pyramids[1 - direction], options);
    });
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("flow: ", error.err));
  }
  return flow;
}

cv::Mat WarpByFlow(const cv::Mat& values, const cv::Mat& flow) {
  cv::Mat2f places(flow.size());
  for (int y = 0; y < flow.rows; ++y) {
    const cv::Vec2f* in = flow.ptr<cv::Vec2f>(y);
    for (int x = 0; x < flow.cols; ++x) {
      places(y, x) = {static_cast<float>(x) + in[x][0], static_cast<float>(y) + in[x][1]};
    }
  }
  cv::Mat warped;
  cv::remap(values, warped, places, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return warped;
}

cv::Point2f SampleField(const cv::Mat& field, cv::Point2f at) {
  return SampleClamped<cv::Point2f>(field, at.x, at.y);
}

bool IsLargeEnoughForFlow(cv::Size size) {
  return size.width >= kMinimumSide && size.height >= kMinimumSide;
}

std::optional<cv::Point2f> FollowFlow(const cv::Mat& there, const cv::Mat& back, cv::Point2f from) {
  const cv::Point2f f = SampleField(there, from);
  const cv::Point2f moved = from + f;
  if (!IsInside(moved.x, moved.y, there.size())) return std::nullopt;
  const cv::Point2f b = SampleField(back, moved);
  const bool returns =
      std::hypot(f.x + b.x, f.y + b.y) < kErrorFloor + kErrorSlope * std::hypot(f.x, f.y);
  return returns ? std::optional(moved) : std::nullopt;
}

TrackedGrid TrackGrid(const FlowPair& flow, const cv::Mat& first, const cv::Mat& second,
                      bool anchor_second, const FlowGridOptions& options) {
  const cv::Mat& there = anchor_second ? flow.backward : flow.forward;
  const cv::Mat& back = anchor_second ? flow.forward : flow.backward;
  const cv::Mat& from = anchor_second ? second : first;
  const cv::Mat& to = anchor_second ? first : second;
  const PatchComparison patches(from, to, there);
  const int stride = options.stride_pixels;
  const auto node_at = [&](int x, int y) {
    Node node{cv::Point2f(static_cast<float>(x), static_cast<float>(y))};
    const PatchComparison::Result patch = patches.At(x, y);
    node.textured = patch.deviation >= kTextureLevels;
    const bool contradicts = node.textured && !(patch.correlation >= kContradiction);
    if (!contradicts) node.there = FollowFlow(there, back, node.place);
    node.agrees = node.textured && node.there && patch.correlation >= kAgreement;
    return node;
  };
  std::vector<std::vector<Node>> rows(NodesOf(there.size(), stride).height);
  kernels::ParallelFor(static_cast<int64_t>(rows.size()), [&](int64_t row) {
    const int y = stride / 2 + static_cast<int>(row) * stride;
    for (int x = stride / 2; x < there.cols; x += stride) {
      if (!IsIgnored(options.ignored, there.size(), x, y)) rows[row].push_back(node_at(x, y));
    }
  });
  TrackedGrid grid;
  for (const std::vector<Node>& row : rows) {
    for (const Node& node : row) {
      if (node.textured) {
        grid.textured.push_back(node.place);
        grid.agrees.push_back(node.agrees ? 1 : 0);
      }
      if (!node.there) continue;
      grid.pairs.push_back(PairOf(node.place, *node.there, anchor_second));
      grid.is_textured.push_back(node.textured ? 1 : 0);
    }
  }
  return grid;
}

}  // namespace egosieve::vision
