#include "vision/labelling/mover_memory.h"

#include "vision/image/node_grid.h"

namespace egosieve::vision {
namespace {

constexpr int kNodeStride = FrameLabellerOptions::kFlowStridePixels;

size_t NodeOf(cv::Point2f place, cv::Size image) {
  return static_cast<size_t>(NearestNode(place, NodesOf(image, kNodeStride), kNodeStride));
}

}  // namespace

MovedNodes MoverMemory::CarriedBy(const std::vector<PointPair>& links, cv::Size image) const {
  if (nodes_.empty()) return {};
  MovedNodes next(nodes_.size(), 0.0f);
  for (const PointPair& link : links) {
    const cv::Point2f before(static_cast<float>(link.x1), static_cast<float>(link.y1));
    const cv::Point2f now(static_cast<float>(link.x2), static_cast<float>(link.y2));
    const size_t node = NodeOf(now, image);
    if (node < next.size()) next[node] = At(nodes_, before, image);
  }
  return next;
}

float MoverMemory::At(const MovedNodes& nodes, cv::Point2f place, cv::Size image) {
  const size_t node = nodes.empty() ? 0 : NodeOf(place, image);
  return node < nodes.size() ? nodes[node] : 0.0f;
}

void MoverMemory::Remember(const std::vector<TrackedPoint>& points, const EvidenceResult& evidence,
                           cv::Size image) {
  nodes_.assign(NodesOf(image, kNodeStride).area(), 0.0f);
  for (size_t i = 0; i < points.size(); ++i) {
    const PointEvidence& point = evidence.points[i];
    if (!point.judged) continue;
    nodes_[NodeOf(points[i].evidence.now, image)] = static_cast<float>(point.probability);
  }
}

}  // namespace egosieve::vision
