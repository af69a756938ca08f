// The fixed pattern of a drive: the median of its pictures, and where a picture agrees with it.
//
// M is the median, pixel by pixel, of pictures spread over the drive: parts that are fixed in the
// image stay sharp in it, all others blur. In a window around each pixel, a picture I is fitted by
// a shifted M,
//
//   I ~ a M(x + u) + b,   a = cov(I, M) / var(M),
//   (cov(G, G) + lambda) u = cov(G, I) / a - cov(G, M),   G the gradient of M              (FX1)
//
// and agrees with it where the correlation of I and M is at least kLeastOfPattern and |u| at most
// kMostShiftPixels. Objects that the camera follows are not fixed to a fraction of a pixel.
//
// Letters and edges fill only a part of a window, and a scene goes by in the rest. There I shows M
// where, with sums over the window weighted by |G|^2,
//
//   rho^2 = (sum G.grad I)^2 / (sum |G|^2  sum |grad I|^2) >= kLeastShown                  (FX2)
//
// That allows for a shift of nearly a pixel. The shift of a whole patch is known better: one a and
// one u of (FX1) by least squares over its pixels, weighted by |G|^2 and with lambda, of I and M
// less their means in the windows.                                                        (FX3)
//
// Pictures are reduced to at most 640 pixels. Reference for the median: Dekel, Rubinstein, Liu &
// Freeman (2017), on watermarks.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

inline constexpr int kFixedPatternWindow = 11;   // pixels
inline constexpr double kMostShiftPixels = 0.3;  // of the reduced picture

// Prepare a grey picture for the pattern: first reduce it, then smooth it.
cv::Mat1b ReducedPicture(const cv::Mat1b& grey);
cv::Mat1f SmoothPicture(const cv::Mat1b& reduced);

// Variance in the window around each pixel, grey levels^2.
cv::Mat1f VarianceInWindow(const cv::Mat1f& picture);

cv::Mat1f MedianPicture(const std::vector<cv::Mat1f>& pictures);

class FixedPattern {
 public:
  // median: M.
  explicit FixedPattern(const cv::Mat1f& median);

  cv::Size size() const { return values_.size(); }
  const cv::Mat1f& variance() const { return variance_; }
  // cov(G, G).
  const cv::Mat1f& xx() const { return xx_; }
  const cv::Mat1f& xy() const { return xy_; }
  const cv::Mat1f& yy() const { return yy_; }

  // 255 where the picture agrees with M (FX1), else 0. picture: from SmoothPicture(), of M's size.
  cv::Mat1b Agreeing(const cv::Mat1f& picture) const;

  // 255 where the picture shows M (FX2), else 0. picture: as above.
  cv::Mat1b Showing(const cv::Mat1f& picture) const;
  // (FX3), u of each patch; infinite where the picture does not show it. picture: as above.
  std::vector<cv::Vec2d> Shifts(const cv::Mat1f& picture,
                                const std::vector<std::vector<cv::Point>>& patches) const;

 private:
  cv::Mat1f power_, mean_power_squared_;  // |G|^2, and the mean of its square
  cv::Mat1f values_, mean_, variance_, gx_, gy_, mean_gx_, mean_gy_, xx_, xy_, yy_, xm_, ym_;
};

}  // namespace egosieve::vision
