// A frame overlaid with its movers or its probability map.
//
// Movers: each has its own colour, an outline, and its number at a corner of its box. The map:
//
//   colour(p)  a diverging map, safe for colour-blind eyes: blue (0) - none (1/2) - orange (1)
//   alpha(p)   opacity over the frame: 0.22 at p = 0, 0.10 at 1/2, 0.65 at 1
//   contour    a light line with dark edges around the objects (vision/objects/map_objects.h)
//
// Areas of the own vehicle are hatched, for any value of the map. Below the picture is a strip with
// the legend: colours, thresholds, the frame's number and time.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "vision/objects/map_objects.h"

namespace egosieve::tools {

struct OverlayOptions {
  vision::ObjectThresholds objects;
  bool legend = true;
  bool outlines_only = false;  // of movers: no fill
  cv::Mat1b ignored;           // not 0: hatched, not coloured; of the frame's size, or empty
};

// frame: CV_8UC3, B G R; probability: of the same size, in [0, 1]. `caption` appears in the legend.
// The legend's strip is as wide as the frame. The result has even sides, as video encoders require.
cv::Mat3b DrawOverlay(const cv::Mat3b& frame, const cv::Mat1f& probability,
                      const std::string& caption, const OverlayOptions& options = {});

// ids: of the frame's size, 0 where static (refine's ids/NNNNNN.png).
cv::Mat3b DrawMovers(const cv::Mat3b& frame, const cv::Mat1w& ids, const std::string& caption,
                     const OverlayOptions& options = {});

// Colour of a mover's number, B G R. Neighbouring numbers differ for colour-blind eyes, too.
cv::Vec3b MoverColour(int number);

}  // namespace egosieve::tools
