// The cells of a mask, followed by flow over several frames.
//
//   cell        square block of pixels, more than half of them in the mask; its place is its centre
//   horizon h   displacement of every cell over h frames: flow sampled bilinearly, step by step. A
//               cell holds as long as it stays in the picture and flow and its return agree to
//               1.2 pixels in each step                                                      (MC1)
//
// Movers that touch and move alike between two frames separate over more frames.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/features/flow_grid.h"

namespace egosieve::vision {

struct MovingCells {
  struct Horizon {
    std::vector<cv::Point2f> displacement;  // one per cell
    std::vector<uint8_t> holds;
  };

  int side = 4;
  cv::Size grid;
  std::vector<cv::Point> cells;     // column and row; in row order
  std::vector<cv::Point2f> places;  // pixels
  std::vector<Horizon> horizons;    // the longest first
};

// links: forward and backward flow from the mask's frame to the next one, from there to the one
// after, and so on. For the past, the links go from frame to frame backwards in time.
MovingCells FollowCells(const cv::Mat1b& mask, const std::vector<FlowPair>& links);

// Indices of the cells whose places lie where `region` is not 0.
std::vector<int> CellsIn(const MovingCells& cells, const cv::Mat1b& region);

}  // namespace egosieve::vision
