// Where the places of a picture are in a later one: what looking ahead adds to a picture's labels.
//
// The flows between consecutive pictures are chained,
//
//   x_0 a node of the grid,  x_(k+1) = x_k + f_k(x_k)                                      (FL1)
//
// each step checked forward and backward as in flow_grid.h. What a mover hides in the picture
// before is seen in a later one, so the two sides together follow places that neither does alone.
#ifndef EGOSIEVE_VISION_LABELLING_FORWARD_LINKS_H_
#define EGOSIEVE_VISION_LABELLING_FORWARD_LINKS_H_

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/features/flow_grid.h"
#include "vision/geometry/point_pair.h"
#include "vision/labelling/extracted_frame.h"

namespace egosieve::vision {

struct ForwardLinks {
  cv::Size nodes;  // of the grid
  // From nodes of the grid (x1, y1) to the later picture (x2, y2).
  std::vector<PointPair> links;
  std::vector<uint8_t> is_textured;  // one a link
  double followed_share = 0.0;       // of the grid's textured nodes, those that were followed

  bool empty() const { return links.empty(); }
};

// Flows between consecutive pictures, each computed once.
class FlowCache {
 public:
  explicit FlowCache(FlowQuality quality) : quality_(quality) {}

  absl::StatusOr<std::shared_ptr<const FlowPair>> Between(const ExtractedFrame& first,
                                                          const ExtractedFrame& second);
  // Drops the flows that begin before the frame `index`.
  void Forget(int64_t index);
  void Clear() { flows_.clear(); }

 private:
  struct Entry {
    int64_t second_index = -1;
    std::shared_ptr<const FlowPair> flow;
  };
  FlowQuality quality_;
  std::map<int64_t, Entry> flows_;  // by the first frame's index
};

// pictures: at least two, of one size, in order; from the first to the last. Empty where they are
// too small for flow.
absl::StatusOr<ForwardLinks> FollowForward(const std::vector<const ExtractedFrame*>& pictures,
                                           const FlowGridOptions& options, FlowCache& flows);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_FORWARD_LINKS_H_
