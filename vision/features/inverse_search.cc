// Compiled without fused multiply-adds: see the header on the order of sums.
#include "vision/features/inverse_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "kernels/base/parallel_for.h"

namespace egosieve::vision {
namespace {

constexpr int kSide = SearchPyramid::kPatchSide, kArea = kSide * kSide;
constexpr int kBorder = SearchPyramid::kBorder;
constexpr int kStripes = 8;
constexpr float kLeastDeterminant = 1e-3f;
constexpr float kInside = 1e-3f;  // pixels from a position of (IS3) to the last pixel, at least
using Sums = cv::Vec<float, 5>;   // as in SearchPyramid

// A patch's row.
using Row = float __attribute__((vector_size(kSide * sizeof(float))));
using WholeRow = int32_t __attribute__((vector_size(kSide * sizeof(int32_t))));

Row Load(const float* from) {
  Row row;
  std::memcpy(&row, from, sizeof(row));
  return row;
}

void AddTo(float* sums, const Row& more) {
  const Row sum = Load(sums) + more;
  std::memcpy(sums, &sum, sizeof(sum));
}

// Four sums of the halves of a, then four of those of b.
Row AddHalves(const Row& a, const Row& b) {
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11) +
         __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
}

float SumOfFirst(const Row& a) { return (a[0] + a[2]) + (a[1] + a[3]); }
float SumOfLast(const Row& a) { return (a[4] + a[6]) + (a[5] + a[7]); }

// J on a displaced patch, interpolated between pixels, row by row in vectors. The sums have the
// order of OpenCV's.
class DisplacedPatch {
 public:
  // (x, y): the corner of the patch.
  DisplacedPatch(const cv::Mat1f& padded, float x, float y) : stride_(padded.step1()) {
    // At least a row and a column of the patch stay in the picture. Outside, the border is
    // repeated, and a search that goes there finds no flow that leads back. NaN becomes the lower
    // limit, too.
    const auto clamp = [](float at, int size) {
      return std::min(std::max(float{kBorder - kSide + 1}, at + kBorder),
                      static_cast<float>(size - kBorder - 1));
    };
    const float left = clamp(x, padded.cols), top = clamp(y, padded.rows);
    const int column = static_cast<int>(left), row = static_cast<int>(top);
    const auto whole_x = static_cast<float>(column), whole_y = static_cast<float>(row);
    const float fx = left - whole_x, fy = top - whole_y;
    const float gx = whole_x + 1.0f - left, gy = whole_y + 1.0f - top;
    first_ = padded.ptr<float>(row) + column;
    weights_ = {gy * gx, gy * fx, fy * gx, fy * fx};
  }

  // Calls use(row, J at the row's pixels).
  template <typename Use>
  void ForEachRow(const Use& use) const {
    Row upper = Load(first_), upper_next = Load(first_ + 1);
    for (int row = 0; row < kSide; ++row) {
      const float* below = first_ + (row + 1) * stride_;
      const Row lower = Load(below), lower_next = Load(below + 1);
      use(row, weights_[0] * upper + weights_[1] * upper_next + weights_[2] * lower +
                   weights_[3] * lower_next);
      upper = lower;
      upper_next = lower_next;
    }
  }

 private:
  size_t stride_;
  const float* first_;
  std::array<float, 4> weights_;
};

// E of (IS1) and the step of (IS2), which is to be subtracted.
struct Evaluation {
  float error = 0.0f;
  cv::Vec2f step;
};

// A patch of I.
class Patch {
 public:
  Patch(const SearchPyramid::Level& level, int x, int y, const Sums& sums)
      : sum_x_(sums[3]), sum_y_(sums[4]) {
    for (int row = 0; row < kSide; ++row) {
      grey_[row] = Load(level.padded.ptr<float>(y + row + kBorder) + x + kBorder);
      gradient_x_[row] = Load(level.gradient_x.ptr<float>(y + row) + x);
      gradient_y_[row] = Load(level.gradient_y.ptr<float>(y + row) + x);
    }
    const float exact = sums[0] * sums[2] - sums[1] * sums[1];
    const float determinant = std::abs(exact) < kLeastDeterminant ? kLeastDeterminant : exact;
    inverse_xx_ = sums[2] / determinant;
    inverse_xy_ = -sums[1] / determinant;
    inverse_yy_ = sums[0] / determinant;
  }

  float Error(const DisplacedPatch& other) const {
    Row squares_and_sum = {};
    other.ForEachRow([&](int row, const Row& there) {
      const Row d = there - grey_[row];
      squares_and_sum += AddHalves(d * d, d);
    });
    return ErrorOf(squares_and_sum);
  }

  Evaluation Evaluate(const DisplacedPatch& other) const {
    Row squares_and_sum = {}, along = {};
    other.ForEachRow([&](int row, const Row& there) {
      const Row d = there - grey_[row];
      squares_and_sum += AddHalves(d * d, d);
      along += AddHalves(d * gradient_x_[row], d * gradient_y_[row]);
    });
    const float sum = SumOfLast(squares_and_sum);
    const float x = SumOfFirst(along) - sum * sum_x_ / kArea;
    const float y = SumOfLast(along) - sum * sum_y_ / kArea;
    return {ErrorOf(squares_and_sum),
            {inverse_xx_ * x + inverse_xy_ * y, inverse_xy_ * x + inverse_yy_ * y}};
  }

 private:
  static float ErrorOf(const Row& squares_and_sum) {
    const float sum = SumOfLast(squares_and_sum);
    return SumOfFirst(squares_and_sum) - sum * sum / kArea;
  }

  std::array<Row, kSide> grey_, gradient_x_, gradient_y_;
  float sum_x_, sum_y_;
  float inverse_xx_ = 0.0f, inverse_xy_ = 0.0f, inverse_yy_ = 0.0f;
};

// The patches of one level.
class LevelSearch {
 public:
  LevelSearch(const SearchPyramid::Level& from, const SearchPyramid::Level& to,
              const InverseSearchOptions& options)
      : from_(from),
        to_(to),
        stride_(options.patch_stride),
        most_steps_(options.most_steps),
        found_(from.sums.size()) {}

  void Run(const cv::Mat1f& start_x, const cv::Mat1f& start_y) {
    const int height = (found_.rows + kStripes - 1) / kStripes;
    kernels::ParallelFor(kStripes, [&](int64_t stripe) {
      const int first = std::min(static_cast<int>(stripe) * height, found_.rows);
      const int last = std::min(first + height, found_.rows) - 1;
      for (int i = first; i <= last; ++i) {
        for (int j = 0; j < found_.cols; ++j) {
          const int y = i * stride_ + kSide / 2, x = j * stride_ + kSide / 2;
          found_(i, j) = {start_x(y, x), start_y(y, x)};
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

  // (IS3)
  void Average(cv::Mat1f& flow_x, cv::Mat1f& flow_y) const {
    Averages averages{cv::Mat1f(from_.grey.size(), 0.0f), cv::Mat1f(from_.grey.size(), 0.0f),
                      cv::Mat1f(from_.grey.size(), 0.0f)};
    for (int i = 0; i < found_.rows; ++i) {
      // The last patches also cover the pixels beyond them.
      const int top = i * stride_;
      const int bottom = i + 1 < found_.rows ? top + kSide : from_.grey.rows;
      for (int j = 0; j < found_.cols; ++j) {
        const int left = j * stride_;
        const int right = j + 1 < found_.cols ? left + kSide : from_.grey.cols;
        for (int y = top; y < bottom; ++y) {
          AddRow(left, y, found_(i, j), averages);
          AddPixels(left + kSide, right, y, found_(i, j), averages);
        }
      }
    }
    flow_x = averages.x / averages.weights;
    flow_y = averages.y / averages.weights;
  }

 private:
  struct Averages {
    cv::Mat1f weights, x, y;  // sums of w_k, and of w_k u_k
  };

  // Two rows of J, and the distances of a position between them from the second and the first.
  struct Lines {
    const float *upper, *lower;
    float above, below;
  };

  // Clamps to an axis of this many pixels. NaN becomes 0.
  static float Inside(float place, int pixels) {
    return std::min(std::max(0.0f, place), static_cast<float>(pixels) - 1.0f - kInside);
  }

  Lines LinesAt(float y) const {
    const float down = Inside(y, from_.grey.rows);
    const int row = static_cast<int>(down);
    return {to_.padded.ptr<float>(row + kBorder) + kBorder,
            to_.padded.ptr<float>(row + 1 + kBorder) + kBorder, static_cast<float>(row + 1) - down,
            down - static_cast<float>(row)};
  }

  void AddPixels(int begin, int end, int y, const cv::Vec2f& u, Averages& averages) const {
    const Lines j = LinesAt(static_cast<float>(y) + u[1]);
    for (int x = begin; x < end; ++x) {
      const float right = Inside(static_cast<float>(x) + u[0], from_.grey.cols);
      const int at = static_cast<int>(right);
      const float before = static_cast<float>(at + 1) - right,
                  after = right - static_cast<float>(at);
      const float d = after * j.below * j.lower[at + 1] + before * j.below * j.lower[at] +
                      after * j.above * j.upper[at + 1] + before * j.above * j.upper[at] -
                      static_cast<float>(from_.grey(y, x));
      const float weight = 1.0f / std::max(1.0f, std::abs(d));
      averages.x(y, x) += weight * u[0];
      averages.y(y, x) += weight * u[1];
      averages.weights(y, x) += weight;
    }
  }

  // AddPixels for kSide pixels together.
  void AddRow(int begin, int y, const cv::Vec2f& u, Averages& averages) const {
    constexpr WholeRow kSteps = {0, 1, 2, 3, 4, 5, 6, 7};
    const Row right = __builtin_convertvector(begin + kSteps, Row) + u[0];
    // Rounding may move a position past a pixel.
    bool is_dense = right[0] == Inside(right[0], from_.grey.cols) &&
                    right[kSide - 1] == Inside(right[kSide - 1], from_.grey.cols);
    const WholeRow at = is_dense ? __builtin_convertvector(right, WholeRow) : kSteps;
    for (int k = 0; k < kSide; ++k) is_dense &= at[k] == at[0] + k;
    if (!is_dense) return AddPixels(begin, begin + kSide, y, u, averages);
    const Lines j = LinesAt(static_cast<float>(y) + u[1]);
    const Row before = __builtin_convertvector(at + 1, Row) - right,
              after = right - __builtin_convertvector(at, Row);
    const float *upper = j.upper + at[0], *lower = j.lower + at[0];
    const Row d = after * j.below * Load(lower + 1) + before * j.below * Load(lower) +
                  after * j.above * Load(upper + 1) + before * j.above * Load(upper) -
                  Load(from_.padded.ptr<float>(y + kBorder) + kBorder + begin);
    const Row size = d < 0.0f ? -d : d;
    const Row weight = 1.0f / (size > 1.0f ? size : Row{} + 1.0f);
    AddTo(averages.x.ptr<float>(y) + begin, weight * u[0]);
    AddTo(averages.y.ptr<float>(y) + begin, weight * u[1]);
    AddTo(averages.weights.ptr<float>(y) + begin, weight);
  }

  DisplacedPatch Displaced(int x, int y, const cv::Vec2f& u) const {
    return DisplacedPatch(to_.padded, static_cast<float>(x) + u[0], static_cast<float>(y) + u[1]);
  }

  void Improve(int i, int j, const cv::Vec2f* beside, const cv::Vec2f* over) {
    const int x = j * stride_, y = i * stride_;
    const Patch patch(from_, x, y, from_.sums(i, j));
    cv::Vec2f start = found_(i, j);
    const Evaluation own = patch.Evaluate(Displaced(x, y, start));
    float least = own.error;
    for (const cv::Vec2f* neighbour : {beside, over}) {
      if (neighbour == nullptr || *neighbour == start) continue;
      const float error = patch.Error(Displaced(x, y, *neighbour));
      if (error >= least) continue;
      least = error;
      start = *neighbour;
    }
    const bool is_own = start == found_(i, j);
    const Evaluation first = is_own ? own : patch.Evaluate(Displaced(x, y, start));
    found_(i, j) = Descend(patch, x, y, start, first);
  }

  // at_start: the evaluation at `start`.
  cv::Vec2f Descend(const Patch& patch, int x, int y, const cv::Vec2f& start,
                    const Evaluation& at_start) const {
    cv::Vec2f found = start - at_start.step;
    float least = at_start.error;
    for (int k = 1; k < most_steps_; ++k) {
      const Evaluation now = patch.Evaluate(Displaced(x, y, found));
      found -= now.step;
      if (!(now.error < least)) break;
      least = now.error;
    }
    return cv::norm(found - start) <= kSide ? found : start;
  }

  const SearchPyramid::Level& from_;
  const SearchPyramid::Level& to_;
  const int stride_, most_steps_;
  cv::Mat2f found_;
};

// The other settings are those of OpenCV's DIS.
void RefineVariationally(const SearchPyramid::Level& from, const SearchPyramid::Level& to,
                         int rounds, cv::Mat1f& flow_x, cv::Mat1f& flow_y) {
  if (rounds == 0) return;
  const auto refinement = cv::VariationalRefinement::create();
  refinement->setAlpha(20.0f);
  refinement->setGamma(10.0f);
  refinement->setDelta(5.0f);
  refinement->setSorIterations(5);
  refinement->setFixedPointIterations(rounds);
  refinement->calcUV(from.grey, to.grey, flow_x, flow_y);
}

}  // namespace

cv::Mat SearchFlow(const SearchPyramid& from, const SearchPyramid& to,
                   const InverseSearchOptions& options) {
  std::array<cv::Mat1f, 2> flow;
  for (cv::Mat1f& component : flow) component = cv::Mat1f(from.levels().back().grey.size(), 0.0f);
  for (int k = static_cast<int>(from.levels().size()) - 1; k >= 0; --k) {
    const SearchPyramid::Level& level = from.levels()[k];
    for (cv::Mat1f& component : flow) {
      if (component.size() == level.grey.size()) continue;
      cv::Mat1f finer;
      cv::resize(component, finer, level.grey.size(), 0.0, 0.0, cv::INTER_LINEAR);
      component = 2.0f * finer;
    }
    LevelSearch search(level, to.levels()[k], options);
    search.Run(flow[0], flow[1]);
    search.Average(flow[0], flow[1]);
    RefineVariationally(level, to.levels()[k], options.refinements, flow[0], flow[1]);
  }
  cv::Mat merged, whole;
  cv::merge(flow.data(), flow.size(), merged);
  cv::resize(merged, whole, from.picture_size(), 0.0, 0.0, cv::INTER_LINEAR);
  whole *= static_cast<double>(1 << from.finest_level());
  return whole;
}

}  // namespace egosieve::vision
