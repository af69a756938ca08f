#include "vision/masks/moving_cells.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "vision/image/inside.h"

namespace egosieve::vision {
namespace {

constexpr float kLargestError = 1.2f;

std::vector<cv::Point2f> Sample(const cv::Mat& flow, const std::vector<cv::Point2f>& places) {
  cv::Mat2f values;
  cv::remap(flow, values, cv::Mat(places).reshape(2, static_cast<int>(places.size())),
            cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return {values.begin(), values.end()};
}

}  // namespace

MovingCells FollowCells(const cv::Mat1b& mask, const std::vector<FlowPair>& links) {
  MovingCells found;
  found.grid = {mask.cols / found.side, mask.rows / found.side};
  for (int row = 0; row < found.grid.height; ++row) {
    for (int column = 0; column < found.grid.width; ++column) {
      const cv::Rect block(column * found.side, row * found.side, found.side, found.side);
      if (2 * cv::countNonZero(mask(block)) <= block.area()) continue;
      found.cells.emplace_back(column, row);
      found.places.emplace_back(static_cast<float>(block.x) + 0.5f * (found.side - 1),
                                static_cast<float>(block.y) + 0.5f * (found.side - 1));
    }
  }
  if (found.cells.empty()) return found;
  std::vector<cv::Point2f> now = found.places;
  std::vector<uint8_t> holds(now.size(), 1);
  for (const FlowPair& link : links) {
    if (link.forward.size() != mask.size()) break;
    const std::vector<cv::Point2f> steps = Sample(link.forward, now);
    for (size_t i = 0; i < now.size(); ++i) now[i] += steps[i];
    const std::vector<cv::Point2f> returns = Sample(link.backward, now);
    MovingCells::Horizon horizon;
    for (size_t i = 0; i < now.size(); ++i) {
      const cv::Point2f error = steps[i] + returns[i];
      if (!IsInside(now[i].x, now[i].y, mask.size()) ||
          !(error.dot(error) < kLargestError * kLargestError)) {
        holds[i] = 0;
      }
      horizon.displacement.push_back(now[i] - found.places[i]);
    }
    horizon.holds = holds;
    found.horizons.push_back(std::move(horizon));
  }
  std::reverse(found.horizons.begin(), found.horizons.end());
  return found;
}

std::vector<int> CellsIn(const MovingCells& cells, const cv::Mat1b& region) {
  std::vector<int> found;
  for (size_t i = 0; i < cells.places.size(); ++i) {
    if (region(cv::Point(cells.places[i])) != 0) found.push_back(static_cast<int>(i));
  }
  return found;
}

}  // namespace egosieve::vision
