// Searches for points that dense flow loses, each by itself.
//
// Coarse-to-fine flow loses small fast objects in the motion of their background. Here nothing is
// smoothed: at half resolution every displacement d within reach is tried,
//
//   E(d) = sum |P - Q_d|   over patches of 8 x 8 pixels,                                    (PA1)
//
// and the best is taken where it is distinct: E + 32 < kMostOfOthers E' for every other
// displacement that is not adjacent (32 is half a grey level per pixel, so that noise does not
// decide between similar ones), and E < kMostOfSpread sum |P - mean P|. It is aligned at full
// resolution in both directions (flow_patch.h). It is kept where the patches correlate, where the
// way back ends at the start and some neighbouring points move alike.
//
// Unlike a search along an epipolar line, it favours neither static nor moving points. Reach: 48
// pixels sideways, 20 up and down. Cost: 48 x 21 displacements of 64 pixels per point.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/features/flow_patch.h"

namespace egosieve::vision {

inline constexpr float kLeastCorrelation = 0.85f;  // of what is found: c of flow_patch.h

// Returns the positions in `to` of the `places` of `from`, one per place. Both pictures have one
// size. spacing: pixels between neighbouring places.
std::vector<std::optional<cv::Point2f>> SearchPatches(const FlowPicture& from,
                                                      const FlowPicture& to,
                                                      const std::vector<cv::Point2f>& places,
                                                      int spacing);

}  // namespace egosieve::vision
