// What the pictures themselves say for a place against another.
//
// Dense flow is smooth: beside a mover it drags what has no texture along, and says that asphalt
// moves. With P, Q, S the patches of 7 x 7 pixels around a point in the frame before, around the
// place that was found for it in the current frame, and around the place where it would be if it
// stood still, each less its mean, and N = 49:
//
//   E_1 = max(|P - Q|^2, N sigma^2),  E_0 = max(|P - S|^2, N sigma^2),  v = min(E_0, E_1) / N
//   l = max(0, kappa (E_0 - E_1) / (2 v))                                                    (S1)
//
// the log-likelihood ratio of the pictures, found place against standing still. No residual may say
// more for moving than l: where both places look alike, nothing was seen. sigma is the median of
// |P - Q| / sqrt(N) over the points of the frame that moved, at least the floor: compressed video
// repeats what stays in place to the bit, noise and all. What fits better than sigma does so by
// chance, or since the found place was searched for, and says nothing. kappa < 1 because
// neighbouring pixels share their noise.
//
// Where the depth is not known, a static point can be anywhere on a segment of its epipolar line.
// What slides along an edge, or looks like its surroundings, has a place there that fits as well:
//
//   l = max(0, min over S on the segment of kappa (E_0 - E_1) / (2 (v + sigma_p^2 G)))     (S2)
//
// with G the mean squared gradient of P and sigma_p the deviation of static points from their line:
// a strong edge differs much from itself half a pixel further. S is taken as large as the point's
// nearness makes it. The inverse depth's own probability is left out, as is that of the motion:
// both are shared by a whole surface, not paid by each point. It is a plane sweep of the places
// that seem to move.
#ifndef EGOSIEVE_VISION_EVIDENCE_PHOTOMETRIC_SUPPORT_H_
#define EGOSIEVE_VISION_EVIDENCE_PHOTOMETRIC_SUPPORT_H_

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace egosieve::vision {

// Where a static point of unknown depth can be, from the farthest to the nearest; in between the
// rest is linear in the place.
struct StaticSegment {
  cv::Point2f first, last;
  double scale_first = 1.0, scale_last = 1.0;  // size in this picture over that in the first
};

class PhotometricSupport {
 public:
  // Two grey pictures, CV_8UC1 of one size; `befores` and `nows` are the points' places in them and
  // set sigma. place_pixels: sigma_p.
  PhotometricSupport(cv::Mat before, cv::Mat now, const std::vector<cv::Point2f>& befores,
                     const std::vector<cv::Point2f>& nows, double place_pixels = 0.0);

  // (S1); nothing where a patch does not lie in its picture: then nothing was seen, either.
  std::optional<double> LogRatio(cv::Point2f before, cv::Point2f now, cv::Point2f standing) const;
  // The same without the bound at 0: below it the pictures prefer the place of standing still.
  std::optional<double> SignedLogRatio(cv::Point2f before, cv::Point2f now,
                                       cv::Point2f standing) const;
  // (S2), for S on the segment in steps of half a pixel, longer ones where that would be more than
  // 400, where S lies in the picture; nothing where it never does.
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

  // kappa (E_0 - E_1) / (2 (v + place_variance)).
  double RatioOf(double still, double found, double place_variance) const;

  cv::Mat before_, now_;
  double noise_levels_ = 0.0, place_pixels_ = 0.0;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_PHOTOMETRIC_SUPPORT_H_
