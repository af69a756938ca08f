// Removes movers that a single frame shows.
//
//   glimpse   a mover that is first seen in a frame and not in the next one, at most
//             kGlimpseSeconds later, where less than half of its place belongs to others      (MG1)
//
// So a glimpse is an error of the map: what moves is in view for twice as long. A view of 70
// degrees is 7 m wide at a distance of 5 m, which a car of 4 m crosses in 0.5 s at 22 m/s.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

inline constexpr double kGlimpseSeconds = 0.25;

// first_seen: numbers first seen in the frame of `numbers`; next: the numbers of the next frame, at
// most kGlimpseSeconds later, of the same size.
void DropGlimpses(const std::vector<uint16_t>& first_seen, const cv::Mat1w& next,
                  cv::Mat1w& numbers);

}  // namespace egosieve::vision
