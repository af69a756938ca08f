// Steps 1 and 2 of evidence_accumulator.h: the terms of a frame. Internal to it.
#pragma once

#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/calibrated_pairs.h"
#include "vision/evidence/evidence_accumulator.h"
#include "vision/evidence/photometric_support.h"

namespace egosieve::vision {

inline bool IsKnown(cv::Point2f p) { return std::isfinite(p.x) && std::isfinite(p.y); }

// The frame's views.
std::vector<CalibratedPair> PairsOfViews(const EvidenceFrame& frame);

// Sets the epipolar term. pictures: null unless both images are given. views: PairsOfViews.
void MeasurePairs(const EvidenceFrame& frame, const PhotometricSupport* pictures,
                  const std::vector<CalibratedPair>& views, EvidenceResult& result);

// Sets `standing` and the road term of `result` where the ground is known.
void MeasureRoad(const EvidenceFrame& frame, const PhotometricSupport* pictures,
                 EvidenceResult& result);

// The same from the longest of `views`, whose depths are the most accurate.
void MeasureRoadAhead(const EvidenceFrame& frame, const std::vector<CalibratedPair>& views,
                      EvidenceResult& result);

}  // namespace egosieve::vision
