#include "vision/features/inverse_search.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace egosieve::vision {
namespace {

constexpr int kSide = SearchPyramid::kPatchSide, kArea = kSide * kSide;
constexpr int kBorder = 16;
constexpr int kCoarsestSide = 32;     // of the longer side, about
constexpr float kSobelWeight = 8.0f;  // of OpenCV's kernel
constexpr float kLeastDeterminant = 1e-3f / 4096;
// Of the steps. Whole ones follow the pictures' noise: less of the flow then leads back.
constexpr float kDamping = 0.125f;
// Of the variational refinement, as in OpenCV's DIS.
constexpr float kSmoothness = 20.0f, kGradients = 10.0f, kBrightness = 5.0f;
constexpr int kRelaxations = 5;

// A patch's row fills a vector register.
using Row = Eigen::Array<float, kSide, 1>;
using ConstRow = Eigen::Map<const Row>;
using MutableRow = Eigen::Map<Row>;

int LevelsOf(cv::Size size) {
  const int longer = std::max(size.width, size.height), shorter = std::min(size.width, size.height);
  const int by_longer = static_cast<int>(std::lround(std::log2(longer / double{kCoarsestSide})));
  const int by_shorter = std::bit_width(static_cast<unsigned>(shorter / kSide)) - 1;
  return std::max(0, std::min(by_longer, by_shorter));
}

SearchPyramid::Level MakeLevel(const cv::Mat1b& grey) {
  SearchPyramid::Level level;
  level.grey = grey;
  cv::Mat1b padded;
  cv::copyMakeBorder(grey, padded, kBorder, kBorder, kBorder, kBorder, cv::BORDER_REPLICATE);
  padded.convertTo(level.padded, CV_32F);
  const double scale = 1.0 / kSobelWeight;
  cv::Sobel(grey, level.gradient_x, CV_32F, 1, 0, 3, scale, 0.0, cv::BORDER_REFLECT_101);
  cv::Sobel(grey, level.gradient_y, CV_32F, 0, 1, 3, scale, 0.0, cv::BORDER_REFLECT_101);
  return level;
}

// The first pixel of patches along an axis; the last patch ends with the picture.
std::vector<int> PatchStarts(int size, int stride) {
  std::vector<int> starts;
  for (int at = 0; at < size - kSide; at += stride) starts.push_back(at);
  starts.push_back(size - kSide);
  return starts;
}

// J at a displaced patch, row by row between pixels.
class DisplacedPatch {
 public:
  DisplacedPatch(const cv::Mat1f& padded, float x, float y) : stride_(padded.step1()) {
    // A patch keeps a row and a column of the picture: what lies beyond repeats the border, and a
    // search that strays there finds nothing that leads back. NaN becomes the least, too.
    const auto clamp = [](float at, int size) {
      return std::min(std::max(float{kBorder - kSide + 1}, at + kBorder),
                      static_cast<float>(size - kBorder - 1));
    };
    const float left = clamp(x, padded.cols), top = clamp(y, padded.rows);
    const int column = static_cast<int>(left), row = static_cast<int>(top);
    const float fx = left - static_cast<float>(column), fy = top - static_cast<float>(row);
    first_ = padded.ptr<float>(row) + column;
    weights_ = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  }
  Row operator()(int row) const {
    const float* upper = first_ + row * stride_;
    const float* lower = upper + stride_;
    return weights_[0] * ConstRow(upper) + weights_[1] * ConstRow(upper + 1) +
           weights_[2] * ConstRow(lower) + weights_[3] * ConstRow(lower + 1);
  }

 private:
  size_t stride_;
  const float* first_;
  std::array<float, 4> weights_;
};

// A patch of I, with its gradients less their means and H's inverse.
struct Patch {
  std::array<Row, kSide> grey, gradient_x, gradient_y;
  float inverse_xx = 0.0f, inverse_xy = 0.0f, inverse_yy = 0.0f;

  Patch(const SearchPyramid::Level& level, int x, int y) {
    Row sum_x = Row::Zero(), sum_y = Row::Zero();
    for (int row = 0; row < kSide; ++row) {
      grey[row] = ConstRow(level.padded.ptr<float>(y + row + kBorder) + x + kBorder);
      gradient_x[row] = ConstRow(level.gradient_x.ptr<float>(y + row) + x);
      gradient_y[row] = ConstRow(level.gradient_y.ptr<float>(y + row) + x);
      sum_x += gradient_x[row];
      sum_y += gradient_y[row];
    }
    const float mean_x = sum_x.sum() / kArea, mean_y = sum_y.sum() / kArea;
    Row xx = Row::Zero(), xy = Row::Zero(), yy = Row::Zero();
    for (int row = 0; row < kSide; ++row) {
      gradient_x[row] -= mean_x;
      gradient_y[row] -= mean_y;
      xx += gradient_x[row] * gradient_x[row];
      xy += gradient_x[row] * gradient_y[row];
      yy += gradient_y[row] * gradient_y[row];
    }
    const float a = xx.sum(), b = xy.sum(), c = yy.sum();
    const float exact = a * c - b * b;
    const float determinant = std::abs(exact) < kLeastDeterminant ? kLeastDeterminant : exact;
    inverse_xx = c / determinant;
    inverse_xy = -b / determinant;
    inverse_yy = a / determinant;
  }

  // (IS1)
  float Error(const DisplacedPatch& other) const {
    Row sum = Row::Zero(), squares = Row::Zero();
    for (int row = 0; row < kSide; ++row) {
      const Row d = other(row) - grey[row];
      sum += d;
      squares += d * d;
    }
    const float total = sum.sum();
    return squares.sum() - total * total / kArea;
  }

  // (IS1), and the step of (IS2) that is to be subtracted.
  float ErrorAndStep(const DisplacedPatch& other, cv::Vec2f& step) const {
    Row sum = Row::Zero(), squares = Row::Zero(), along_x = Row::Zero(), along_y = Row::Zero();
    for (int row = 0; row < kSide; ++row) {
      const Row d = other(row) - grey[row];
      sum += d;
      squares += d * d;
      along_x += d * gradient_x[row];
      along_y += d * gradient_y[row];
    }
    const float x = along_x.sum(), y = along_y.sum(), total = sum.sum();
    step = {inverse_xx * x + inverse_xy * y, inverse_xy * x + inverse_yy * y};
    return squares.sum() - total * total / kArea;
  }
};

// The patches of one level.
class LevelSearch {
 public:
  LevelSearch(const SearchPyramid::Level& from, const SearchPyramid::Level& to,
              const InverseSearchOptions& options)
      : from_(from),
        to_(to),
        most_steps_(options.most_steps),
        columns_(PatchStarts(from.grey.cols, options.patch_stride)),
        rows_(PatchStarts(from.grey.rows, options.patch_stride)),
        found_(columns_.size() * rows_.size()) {}

  void Run(const cv::Mat2f& start) {
    const int across = static_cast<int>(columns_.size()), down = static_cast<int>(rows_.size());
    for (int i = 0; i < down; ++i) {
      for (int j = 0; j < across; ++j) {
        const cv::Vec2f coarse = start(rows_[i] + kSide / 2, columns_[j] + kSide / 2);
        Improve(i, j, coarse, j > 0 ? &At(i, j - 1) : nullptr, i > 0 ? &At(i - 1, j) : nullptr);
      }
    }
    for (int i = down - 1; i >= 0; --i) {
      for (int j = across - 1; j >= 0; --j) {
        Improve(i, j, At(i, j), j + 1 < across ? &At(i, j + 1) : nullptr,
                i + 1 < down ? &At(i + 1, j) : nullptr);
      }
    }
  }

  // (IS3)
  void Average(cv::Mat1f& flow_x, cv::Mat1f& flow_y) const {
    cv::Mat1f weights(from_.grey.size(), 0.0f);
    flow_x = cv::Mat1f(from_.grey.size(), 0.0f);
    flow_y = cv::Mat1f(from_.grey.size(), 0.0f);
    for (size_t k = 0; k < found_.size(); ++k) {
      const int x = columns_[k % columns_.size()], y = rows_[k / columns_.size()];
      const cv::Vec2f u = found_[k];
      const DisplacedPatch other = Displaced(x, y, u);
      for (int row = 0; row < kSide; ++row) {
        const ConstRow grey(from_.padded.ptr<float>(y + row + kBorder) + x + kBorder);
        const Row weight = (other(row) - grey).abs().max(1.0f).inverse();
        MutableRow(weights.ptr<float>(y + row) + x) += weight;
        MutableRow(flow_x.ptr<float>(y + row) + x) += u[0] * weight;
        MutableRow(flow_y.ptr<float>(y + row) + x) += u[1] * weight;
      }
    }
    cv::divide(flow_x, weights, flow_x);
    cv::divide(flow_y, weights, flow_y);
  }

 private:
  cv::Vec2f& At(int i, int j) { return found_[i * columns_.size() + j]; }

  DisplacedPatch Displaced(int x, int y, const cv::Vec2f& u) const {
    return DisplacedPatch(to_.padded, static_cast<float>(x) + u[0], static_cast<float>(y) + u[1]);
  }

  void Improve(int i, int j, cv::Vec2f start, const cv::Vec2f* beside, const cv::Vec2f* over) {
    const int x = columns_[j], y = rows_[i];
    const Patch patch(from_, x, y);
    float least = patch.Error(Displaced(x, y, start));
    for (const cv::Vec2f* neighbour : {beside, over}) {
      if (neighbour == nullptr || *neighbour == start) continue;
      const float error = patch.Error(Displaced(x, y, *neighbour));
      if (error >= least) continue;
      least = error;
      start = *neighbour;
    }
    At(i, j) = Descend(patch, x, y, start);
  }

  cv::Vec2f Descend(const Patch& patch, int x, int y, const cv::Vec2f& start) const {
    cv::Vec2f found = start, step;
    float least = std::numeric_limits<float>::infinity();
    for (int k = 0; k < most_steps_; ++k) {
      const float error = patch.ErrorAndStep(Displaced(x, y, found), step);
      found -= kDamping * step;
      if (!(error < least)) break;
      least = error;
    }
    const cv::Vec2f way = found - start;
    return way.dot(way) <= kArea ? found : start;
  }

  const SearchPyramid::Level& from_;
  const SearchPyramid::Level& to_;
  const int most_steps_;
  const std::vector<int> columns_, rows_;
  std::vector<cv::Vec2f> found_;
};

void RefineVariationally(const SearchPyramid::Level& from, const SearchPyramid::Level& to,
                         int rounds, cv::Mat1f& flow_x, cv::Mat1f& flow_y) {
  if (rounds == 0) return;
  const auto refinement = cv::VariationalRefinement::create();
  refinement->setAlpha(kSmoothness);
  refinement->setGamma(kGradients);
  refinement->setDelta(kBrightness);
  refinement->setSorIterations(kRelaxations);
  refinement->setFixedPointIterations(rounds);
  refinement->calcUV(from.grey, to.grey, flow_x, flow_y);
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
    levels_.push_back(MakeLevel(grey));
  }
}

cv::Mat SearchFlow(const SearchPyramid& from, const SearchPyramid& to,
                   const InverseSearchOptions& options) {
  cv::Mat2f flow(from.levels().back().grey.size(), cv::Vec2f(0.0f, 0.0f));
  for (int k = static_cast<int>(from.levels().size()) - 1; k >= 0; --k) {
    const SearchPyramid::Level& level = from.levels()[k];
    if (flow.size() != level.grey.size()) {
      cv::Mat2f coarse;
      cv::resize(flow, coarse, level.grey.size(), 0.0, 0.0, cv::INTER_LINEAR);
      flow = 2.0f * coarse;
    }
    LevelSearch search(level, to.levels()[k], options);
    search.Run(flow);
    cv::Mat1f flow_x, flow_y;
    search.Average(flow_x, flow_y);
    RefineVariationally(level, to.levels()[k], options.refinements, flow_x, flow_y);
    cv::merge(std::array<cv::Mat, 2>{flow_x, flow_y}, flow);
  }
  cv::Mat whole;
  cv::resize(flow, whole, from.picture_size(), 0.0, 0.0, cv::INTER_LINEAR);
  whole *= static_cast<double>(1 << from.finest_level());
  return whole;
}

}  // namespace egosieve::vision
