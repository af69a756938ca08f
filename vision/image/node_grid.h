// The nodes of a regular grid over a picture: every stride-th column and row from stride / 2 on,
// numbered row by row. Positions are in pixels; strides are positive.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

namespace egosieve::vision {

// Columns and rows.
inline cv::Size NodesOf(cv::Size picture, int stride_pixels) {
  const auto count = [&](int pixels) {
    const int first = stride_pixels / 2;
    return pixels > first ? (pixels - 1 - first) / stride_pixels + 1 : 0;
  };
  return {count(picture.width), count(picture.height)};
}

// node: column and row.
inline cv::Point2f PlaceOfNode(cv::Point node, int stride_pixels) {
  const int first = stride_pixels / 2;
  return {static_cast<float>(first + node.x * stride_pixels),
          static_cast<float>(first + node.y * stride_pixels)};
}

inline cv::Point2f PlaceOfNode(int node, int columns, int stride_pixels) {
  return PlaceOfNode({node % columns, node / columns}, stride_pixels);
}

// The node at such a place.
inline int64_t NodeAt(double x, double y, int columns, int stride_pixels) {
  const int first = stride_pixels / 2;
  const auto column = static_cast<int64_t>((x - first) / stride_pixels);
  const auto row = static_cast<int64_t>((y - first) / stride_pixels);
  return row * columns + column;
}

// nodes: not empty.
inline int64_t NearestNode(cv::Point2f place, cv::Size nodes, int stride_pixels) {
  const auto nearest = [&](float pixels, int count) {
    const auto node = std::lround((pixels - stride_pixels / 2) / static_cast<float>(stride_pixels));
    return std::clamp<int64_t>(node, 0, count - 1);
  };
  return nearest(place.y, nodes.height) * nodes.width + nearest(place.x, nodes.width);
}

}  // namespace egosieve::vision
