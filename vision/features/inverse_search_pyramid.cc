#include <algorithm>
#include <bit>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/features/inverse_search.h"

namespace egosieve::vision {
namespace {

constexpr int kSide = SearchPyramid::kPatchSide, kBorder = SearchPyramid::kBorder;
constexpr int kCoarsestSide = 32;  // approximate longer side, pixels

using Sums = cv::Vec<float, 5>;

int LevelsOf(cv::Size size) {
  const int longer = std::max(size.width, size.height), shorter = std::min(size.width, size.height);
  const int by_longer = static_cast<int>(std::lround(std::log2(longer / double{kCoarsestSide})));
  const int by_shorter = std::bit_width(static_cast<unsigned>(shorter / kSide)) - 1;
  return std::max(0, std::min(by_longer, by_shorter));
}

int PatchesAlong(int pixels, int stride) { return 1 + (pixels - kSide) / stride; }

// The sums over the rows of patches: whole numbers, so that floats are exact.
cv::Mat_<Sums> SumRows(const cv::Mat1f& along_x, const cv::Mat1f& along_y, int stride) {
  cv::Mat_<Sums> rows(along_x.rows, PatchesAlong(along_x.cols, stride));
  for (int y = 0; y < rows.rows; ++y) {
    for (int k = 0; k < rows.cols; ++k) {
      const float *gx = along_x.ptr<float>(y) + k * stride,
                  *gy = along_y.ptr<float>(y) + k * stride;
      Sums sums = Sums::all(0.0f);
      for (int i = 0; i < kSide; ++i) {
        sums[0] += gx[i] * gx[i];
        sums[1] += gx[i] * gy[i];
        sums[2] += gy[i] * gy[i];
        sums[3] += gx[i];
        sums[4] += gy[i];
      }
      rows(y, k) = sums;
    }
  }
  return rows;
}

cv::Mat_<Sums> SumPatches(const cv::Mat1f& along_x, const cv::Mat1f& along_y, int stride) {
  const cv::Mat_<Sums> rows = SumRows(along_x, along_y, stride);
  cv::Mat_<Sums> patches(PatchesAlong(along_x.rows, stride), rows.cols);
  std::vector<Sums> running(rows.cols, Sums::all(0.0f));
  for (int y = 0; y < rows.rows; ++y) {
    for (int k = 0; k < rows.cols; ++k) {
      running[k] += y < kSide ? rows(y, k) : rows(y, k) - rows(y - kSide, k);
    }
    const int top = y - kSide + 1;
    if (top >= 0 && top % stride == 0) {
      std::copy(running.begin(), running.end(), patches[top / stride]);
    }
  }
  return patches;
}

SearchPyramid::Level MakeLevel(const cv::Mat1b& grey, int stride) {
  SearchPyramid::Level level;
  level.grey = grey;
  cv::Mat1b padded;
  cv::copyMakeBorder(grey, padded, kBorder, kBorder, kBorder, kBorder, cv::BORDER_REPLICATE);
  padded.convertTo(level.padded, CV_32F);
  cv::Mat along_x, along_y;
  cv::spatialGradient(grey, along_x, along_y);
  along_x.convertTo(level.gradient_x, CV_32F);
  along_y.convertTo(level.gradient_y, CV_32F);
  level.sums = SumPatches(level.gradient_x, level.gradient_y, stride);
  return level;
}

}  // namespace

SearchPyramid::SearchPyramid(const cv::Mat& picture, const InverseSearchOptions& options)
    : picture_size_(picture.size()) {
  const int coarsest = LevelsOf(picture.size());
  finest_level_ = std::min(options.finest_level, coarsest);
  for (int level = finest_level_; level <= coarsest; ++level) {
    const cv::Mat larger = levels_.empty() ? picture : cv::Mat(levels_.back().grey);
    const int by = levels_.empty() ? level : 1;
    cv::Mat1b grey;
    cv::resize(larger, grey, {larger.cols >> by, larger.rows >> by}, 0.0, 0.0, cv::INTER_AREA);
    levels_.push_back(MakeLevel(grey, options.patch_stride));
  }
}

}  // namespace egosieve::vision
