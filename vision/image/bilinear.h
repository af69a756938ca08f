// Bilinear samples of values that lie at whole positions (x, y), 0 <= x < columns, 0 <= y < rows.
//
// With a, b in the row above (x, y), c, d in the row below and s, t the shares of the second column
// and row,
//
//   by weights       (1 - t) ((1 - s) a + s b) + t ((1 - s) c + s d)                          (BI1)
//   by differences   u + t (v - u),   u = a + s (b - a),   v = c + s (d - c)                  (BI2)
//
// These differ in rounding: (BI1) is exact at every whole position where the four values are finite,
// (BI2) where they are equal. At the border positions are clamped, so that the outermost values go
// on outside, or a sample outside is NaN; each function says which. Clamped positions must not be
// NaN.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>

namespace egosieve::vision {

// The whole positions around a position along one axis; share: of `high`.
template <typename Real>
struct Around {
  int low, high;
  Real share;
};

// What a position at the last whole position lies between.
enum class AtLast {
  kPair,   // the last two, with share 1
  kAlone,  // the last one alone, with share 0
};

// The position is clamped to [0, count - 1]. count: positive; of one value, low = high = 0.
template <AtLast kAtLast = AtLast::kPair, typename Real>
Around<Real> AroundClamped(Real at, int count) {
  const int last = count - 1;
  const Real inside = std::clamp(at, Real{0}, static_cast<Real>(last));
  const int low =
      std::min(static_cast<int>(inside), kAtLast == AtLast::kAlone ? last : std::max(last - 1, 0));
  return {low, std::min(low + 1, last), inside - static_cast<Real>(low)};
}

// (BI1); value(row, column).
template <typename Real, typename Value>
auto BilinearByWeights(const Around<Real>& x, const Around<Real>& y, const Value& value) {
  return (1 - y.share) * ((1 - x.share) * value(y.low, x.low) + x.share * value(y.low, x.high)) +
         y.share * ((1 - x.share) * value(y.high, x.low) + x.share * value(y.high, x.high));
}

template <typename Value, typename Real>
auto Between(Value low, Value high, Real share) {
  return low + share * (high - low);
}

// (BI2); value(row, column).
template <typename Real, typename Value>
auto BilinearByDifferences(const Around<Real>& x, const Around<Real>& y, const Value& value) {
  const auto above = Between(value(y.low, x.low), value(y.low, x.high), x.share);
  const auto below = Between(value(y.high, x.low), value(y.high, x.high), x.share);
  return Between(above, below, y.share);
}

// (BI1) of a matrix of Pixel, clamped.
template <typename Pixel>
Pixel SampleClamped(const cv::Mat& values, float x, float y) {
  return BilinearByWeights(AroundClamped(x, values.cols), AroundClamped(y, values.rows),
                           [&](int row, int column) { return values.at<Pixel>(row, column); });
}

// (BI2) of a CV_8UC1 picture; NaN outside of it and in its last column and row.
inline float SampleOrNan(const cv::Mat& picture, double x, double y) {
  if (!(x >= 0 && y >= 0 && x < picture.cols - 1 && y < picture.rows - 1)) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const uint8_t* const rows[2] = {picture.ptr<uint8_t>(row) + column,
                                  picture.ptr<uint8_t>(row + 1) + column};
  return BilinearByDifferences(Around<float>{0, 1, static_cast<float>(x - column)},
                               Around<float>{0, 1, static_cast<float>(y - row)},
                               [&](int below, int right) { return rows[below][right]; });
}

}  // namespace egosieve::vision
