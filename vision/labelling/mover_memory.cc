#include "vision/labelling/mover_memory.h"

#include "vision/labelling/pair_motions.h"

namespace egosieve::vision {

MovedNodes MoverMemory::CarriedBy(const std::vector<PointPair>& links, cv::Size image) const {
  if (nodes_.empty()) return {};
  MovedNodes next(nodes_.size(), 0.0f);
  const int columns = NodesOf(image, stride_pixels_).width;
  for (const PointPair& link : links) {
    const auto node = static_cast<size_t>(NodeAt(link.x2, link.y2, columns, stride_pixels_));
    const cv::Point2f before(static_cast<float>(link.x1), static_cast<float>(link.y1));
    if (node < next.size()) next[node] = At(nodes_, before, image);
  }
  return next;
}

float MoverMemory::At(const MovedNodes& nodes, cv::Point2f place, cv::Size image) const {
  const double half = 0.5 * stride_pixels_;  // to the nearest
  const auto node = static_cast<size_t>(
      NodeAt(place.x + half, place.y + half, NodesOf(image, stride_pixels_).width, stride_pixels_));
  return node < nodes.size() ? nodes[node] : 0.0f;
}

void MoverMemory::Remember(const std::vector<TrackedPoint>& points, const EvidenceResult& evidence,
                           cv::Size image) {
  const cv::Size nodes = NodesOf(image, stride_pixels_);
  nodes_.assign(nodes.area(), 0.0f);
  for (size_t i = 0; i < points.size(); ++i) {
    const PointEvidence& point = evidence.points[i];
    if (!point.judged || point.own_car) continue;
    const cv::Point2f place = points[i].evidence.now;
    const auto node = static_cast<size_t>(NodeAt(place.x, place.y, nodes.width, stride_pixels_));
    if (node < nodes_.size()) nodes_[node] = static_cast<float>(point.probability);
  }
}

}  // namespace egosieve::vision
