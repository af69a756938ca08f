// Remembers which places of the last picture moved. In the next pair of pictures they have little
// weight for the camera's motion (two_view_motion.h, TV7), because movers usually keep moving. So a
// mover that fills most of the picture is not mistaken for the static scene. Not used where the
// first pass found that the camera is on a vehicle: then the direction of travel has the same
// effect (travel_prior.h). Nor without the evidence term of accumulation.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "vision/evidence/evidence_accumulator.h"
#include "vision/geometry/point_pair.h"
#include "vision/labelling/evidence_labeller.h"

namespace egosieve::vision {

// Probability of having moved for each node of a picture's grid, row by row; 0 where not known.
// Empty: not known for any node.
using MovedNodes = std::vector<float>;

class MoverMemory {
 public:
  // Of the last picture.
  const MovedNodes& nodes() const { return nodes_; }
  // The probabilities moved to the next picture. links: from the last picture (1) to nodes of the
  // next one (2).
  MovedNodes CarriedBy(const std::vector<PointPair>& links, cv::Size image) const;
  // The probability at a place of a picture with the probabilities `nodes`.
  static float At(const MovedNodes& nodes, cv::Point2f place, cv::Size image);

  // Stores the probabilities of the last picture.
  void Remember(const std::vector<TrackedPoint>& points, const EvidenceResult& evidence,
                cv::Size image);
  void Forget() { nodes_.clear(); }
  void Restore(MovedNodes nodes) { nodes_ = std::move(nodes); }

 private:
  MovedNodes nodes_;
};

}  // namespace egosieve::vision
