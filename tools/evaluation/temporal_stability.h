// How much an outline changes its shape between frames: the temporal instability T of DAVIS.
//
//   contour      the longest outline of the mask, as a polygon within 3 pixels of it, with points
//                at most 3 pixels apart
//   descriptor   shape context of each point: the positions of the contour's points relative to it,
//                in 12 directions and 5 rings; the rings' outer radii are spaced evenly in their
//                logarithms from 1/8 to 2 mean distances between points
//   c(i, j)      1/2 sum (h_i - h_j)^2 / (h_i + h_j), h normalised to sum 1
//   matching     the monotone path of least cost through c (dynamic time warping), begun at the two
//                contours' first points; then again, begun at that path's best pair
//   T            mean cost of the path's pairs, each point kept only in its best pair
//
// T is 0 if the shape only moves, turns little and grows; flickering or boiling masks have a large
// T. The T of the truth tells how much the object itself deforms.
//
// Reference: Perazzi et al., A Benchmark Dataset and Evaluation Methodology for Video Object
// Segmentation (CVPR 2016), section 4, and its program.
#ifndef EGOSIEVE_TOOLS_EVALUATION_TEMPORAL_STABILITY_H_
#define EGOSIEVE_TOOLS_EVALUATION_TEMPORAL_STABILITY_H_

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace egosieve::tools {

using ShapeContext = std::array<float, 60>;

// Descriptors along the longest contour; empty if the mask has none.
std::vector<ShapeContext> DescribeOutline(const cv::Mat1b& mask);

// T between the outlines of consecutive frames; absent if one has no contour.
std::optional<double> OutlineChange(const std::vector<ShapeContext>& before,
                                    const std::vector<ShapeContext>& now);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_TEMPORAL_STABILITY_H_
