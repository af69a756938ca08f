#include "vision/features/inverse_search.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "kernels/base/parallel_for.h"
#include "vision/features/flow_refinement.h"

namespace egosieve::vision {
namespace {

constexpr int kSide = kFlowPatchSide;
constexpr int kStripes = 8;
constexpr int kStepsPerPass = 3;   // at most, of a patch
constexpr int kCoarsestSide = 32;  // approximate longer side, pixels

int LevelsOf(cv::Size size) {
  const int longer = std::max(size.width, size.height), shorter = std::min(size.width, size.height);
  const int by_longer = static_cast<int>(std::lround(std::log2(longer / double{kCoarsestSide})));
  const int by_shorter = std::bit_width(static_cast<unsigned>(shorter / kSide)) - 1;
  return std::max(0, std::min(by_longer, by_shorter));
}

// Corners of patches along an axis; the last patch ends with the picture.
std::vector<int> CornersAlong(int pixels, int stride) {
  std::vector<int> corners;
  for (int corner = 0; corner < pixels - kSide; corner += stride) corners.push_back(corner);
  corners.push_back(pixels - kSide);
  return corners;
}

void AddTo(float* sums, const FlowPatchRow& more) {
  const FlowPatchRow sum = LoadFlowPatchRow(sums) + more;
  std::memcpy(sums, &sum, sizeof(sum));
}

// The patches of one level.
class LevelSearch {
 public:
  LevelSearch(const FlowPicture& from, const FlowPicture& to, const InverseSearchOptions& options)
      : from_(from),
        to_(to),
        left_(CornersAlong(from.size().width, options.patch_stride)),
        top_(CornersAlong(from.size().height, options.patch_stride)),
        found_(static_cast<int>(top_.size()), static_cast<int>(left_.size())) {}

  void Run(const cv::Mat2f& start) {
    const int height = (found_.rows + kStripes - 1) / kStripes;
    kernels::ParallelFor(kStripes, [&](int64_t stripe) {
      const int first = std::min(static_cast<int>(stripe) * height, found_.rows);
      const int last = std::min(first + height, found_.rows) - 1;
      for (int i = first; i <= last; ++i) {
        for (int j = 0; j < found_.cols; ++j) {
          found_(i, j) = start(top_[i] + kSide / 2, left_[j] + kSide / 2);
          Improve(i, j, j > 0 ? &found_(i, j - 1) : nullptr,
                  i > first ? &found_(i - 1, j) : nullptr);
        }
      }
      for (int i = last; i >= first; --i) {
        for (int j = found_.cols - 1; j >= 0; --j) {
          Improve(i, j, j + 1 < found_.cols ? &found_(i, j + 1) : nullptr,
                  i < last ? &found_(i + 1, j) : nullptr);
        }
      }
    });
  }

  // (IS1)
  cv::Mat2f Average() const {
    cv::Mat1f weights(from_.size(), 0.0f), x(from_.size(), 0.0f), y(from_.size(), 0.0f);
    for (int i = 0; i < found_.rows; ++i) {
      for (int j = 0; j < found_.cols; ++j) {
        const cv::Vec2f u = found_(i, j);
        const int column = left_[j];
        FlowPatchRows(to_, CornerOf(i, j) + cv::Point2f(u))
            .ForEach([&](int k, const FlowPatchRow& there) {
              const int row = top_[i] + k;
              const FlowPatchRow d = there - LoadFlowPatchRow(from_.At(column, row));
              const FlowPatchRow size = d < 0.0f ? -d : d;
              const FlowPatchRow weight = 1.0f / (size > 1.0f ? size : FlowPatchRow{} + 1.0f);
              AddTo(weights.ptr<float>(row) + column, weight);
              AddTo(x.ptr<float>(row) + column, weight * u[0]);
              AddTo(y.ptr<float>(row) + column, weight * u[1]);
            });
      }
    }
    cv::Mat2f flow;
    cv::merge(std::vector<cv::Mat>{x / weights, y / weights}, flow);
    return flow;
  }

 private:
  cv::Point2f CornerOf(int i, int j) const {
    return {static_cast<float>(left_[j]), static_cast<float>(top_[i])};
  }

  void Improve(int i, int j, const cv::Vec2f* beside, const cv::Vec2f* over) {
    const cv::Point2f corner = CornerOf(i, j);
    const FlowPatch patch(from_, corner);
    cv::Vec2f start = found_(i, j);
    FlowPatchMatch match = patch.Compare(to_, corner + cv::Point2f(start));
    for (const cv::Vec2f* neighbour : {beside, over}) {
      if (neighbour == nullptr || *neighbour == start) continue;
      const FlowPatchMatch other = patch.Compare(to_, corner + cv::Point2f(*neighbour));
      if (other.error >= match.error) continue;
      match = other;
      start = *neighbour;
    }
    found_(i, j) =
        patch.Align(to_, corner + cv::Point2f(start), match, kStepsPerPass).corner - corner;
  }

  const FlowPicture& from_;
  const FlowPicture& to_;
  const std::vector<int> left_, top_;
  cv::Mat2f found_;
};

// To this size, displacements times `by`.
cv::Mat2f Resized(const cv::Mat2f& flow, cv::Size size, double by) {
  cv::Mat2f resized;
  cv::resize(flow, resized, size, 0.0, 0.0, cv::INTER_LINEAR);
  resized *= by;
  return resized;
}

}  // namespace

SearchPyramid::SearchPyramid(const cv::Mat& picture, int finest_level)
    : picture_size_(picture.size()) {
  const int coarsest = LevelsOf(picture.size());
  finest_level_ = std::min(finest_level, coarsest);
  for (int level = finest_level_; level <= coarsest; ++level) {
    const cv::Mat larger = levels_.empty() ? picture : cv::Mat(levels_.back().grey);
    const int by = levels_.empty() ? level : 1;
    cv::Mat1b grey;
    cv::resize(larger, grey, {larger.cols >> by, larger.rows >> by}, 0.0, 0.0, cv::INTER_AREA);
    levels_.push_back({grey, FlowPicture(grey)});
  }
}

cv::Mat SearchFlow(const SearchPyramid& from, const SearchPyramid& to,
                   const InverseSearchOptions& options) {
  cv::Mat2f flow(from.levels().back().grey.size(), cv::Vec2f(0.0f, 0.0f));
  for (size_t k = from.levels().size(); k-- > 0;) {
    const SearchPyramid::Level &level = from.levels()[k], &other = to.levels()[k];
    if (flow.size() != level.grey.size()) flow = Resized(flow, level.grey.size(), 2.0);
    LevelSearch search(level.patches, other.patches, options);
    search.Run(flow);
    flow = search.Average();
    RefineFlow(level.patches, other.patches, options.refinements, flow);
  }
  return Resized(flow, from.picture_size(), static_cast<double>(1 << from.finest_level()));
}

}  // namespace egosieve::vision
