// Whether two pictures show one scene, by the flow between them alone (scene_agreement.h).
#pragma once

#include <opencv2/core.hpp>

#include "vision/features/flow_grid.h"

namespace egosieve::vision {

bool ShowOneScene(const FlowPair& flow, const cv::Mat& first, const cv::Mat& second);

}  // namespace egosieve::vision
