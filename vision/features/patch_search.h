// Places that dense flow loses, each searched for by itself.
//
// Going from coarse to fine, flow loses what is small and moves fast in the motion of what is
// behind it. Here nothing is smooth: at half resolution every displacement d within reach is tried,
//
//   E(d) = sum |P - Q_d|   over patches of 8 x 8 pixels,                                     (P1)
//
// and the best is taken where no other but those beside it comes near: E + 32 < kMostOfOthers E' of
// the best other (half a grey level a pixel, lest noise decides among alike ones), and E <
// kMostOfSpread sum |P - mean P|. It is refined at full resolution there and back (Lucas-Kanade),
// and kept where that ends where it began and some places near it moved alike.
//
// Unlike a search along an epipolar line, it favours neither what stands nor what moves. Reach: 48
// pixels sideways, 20 up and down. Cost: 10 us a place.
#ifndef EGOSIEVE_VISION_FEATURES_PATCH_SEARCH_H_
#define EGOSIEVE_VISION_FEATURES_PATCH_SEARCH_H_

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace egosieve::vision {

// Where the `places` of `from` are in `to`, one a place; both CV_8UC1 and of one size. spacing:
// pixels between neighbouring places.
std::vector<std::optional<cv::Point2f>> SearchPatches(const cv::Mat& from, const cv::Mat& to,
                                                      const std::vector<cv::Point2f>& places,
                                                      int spacing);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FEATURES_PATCH_SEARCH_H_
