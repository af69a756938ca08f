// Evidence from grey levels: whether a point's found position fits better than its position if it
// were static.
//
// Dense flow is smooth: beside a mover it carries textureless surroundings along, so that asphalt
// seems to move. With P, Q, S the patches of 7 x 7 pixels around a point in the frame before,
// around its found position in the current frame, and around its static position there, each less
// its mean, and N = 49:
//
//   E_1 = max(|P - Q|^2, N sigma^2),  E_0 = max(|P - S|^2, N sigma^2),  v = min(E_0, E_1) / N
//   l = kappa (E_0 - E_1) / (2 v)                                                            (S1)
//
// is the log-likelihood ratio of the found against the static position. sigma is
// the median of |P - Q| / sqrt(N) over the points of the frame that moved, at least the floor.
// Points that did not move are left out, because compressed video repeats unchanged parts bit for
// bit, with their noise. A fit better than sigma is due to chance, or to the search for the found
// position, and is no evidence. kappa < 1 because neighbouring pixels share their noise.
//
// If the depth is not known, a static point can be anywhere on a segment of its epipolar line. A
// point that slides along an edge, or looks like its surroundings, fits as well somewhere on the
// segment:
//
//   l = max(0, min over S on the segment of kappa (E_0 - E_1) / (2 (v + sigma_p^2 G)))     (S2)
//
// It limits the evidence for motion of every residual: where both positions look alike, the residual
// is no evidence. G is the mean squared gradient of P, sigma_p the deviation of static points from
// their line: a strong edge changes much within half a pixel. S is sampled at the scale that its
// depth implies.
// The prior probabilities of the inverse depth and of the motion are left out, because they apply
// once to a whole surface, not to each point. (S2) is a plane sweep for points that seem to move.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace egosieve::vision {

// Possible positions of a static point of unknown depth, from the farthest to the nearest. The
// scale is interpolated linearly in between.
struct StaticSegment {
  cv::Point2f first, last;
  double scale_first = 1.0, scale_last = 1.0;  // size in this picture over that in the first
};

class PhotometricSupport {
 public:
  // Two grey pictures, CV_8UC1 of one size. sigma is estimated from the points' positions `befores`
  // and `nows` in them. place_pixels: sigma_p.
  PhotometricSupport(cv::Mat before, cv::Mat now, const std::vector<cv::Point2f>& befores,
                     const std::vector<cv::Point2f>& nows, double place_pixels = 0.0);

  // (S1) with S at `standing`, negative where that fits better; nullopt where a patch does not lie in its picture.
  std::optional<double> LogRatio(cv::Point2f before, cv::Point2f now, cv::Point2f standing) const;
  // (S2), with S in steps of half a pixel along the segment, or 400 longer steps if there would be
  // more. Steps where S leaves the picture are skipped; nullopt if all are.
  std::optional<double> LogRatioOnSegment(cv::Point2f before, cv::Point2f now,
                                          const StaticSegment& segment) const;

  // The two pictures exchanged.
  PhotometricSupport Reversed() const {
    return PhotometricSupport(now_, before_, noise_levels_, place_pixels_);
  }

  double noise_levels() const { return noise_levels_; }

 private:
  PhotometricSupport(cv::Mat before, cv::Mat now, double noise_levels, double place_pixels)
      : before_(std::move(before)),
        now_(std::move(now)),
        noise_levels_(noise_levels),
        place_pixels_(place_pixels) {}

  double LeastDifference() const;  // N sigma^2
  // kappa (E_0 - E_1) / (2 (v + place_variance)).
  double RatioOf(double still, double found, double place_variance) const;

  cv::Mat before_, now_;
  double noise_levels_ = 0.0, place_pixels_ = 0.0;
};

}  // namespace egosieve::vision
