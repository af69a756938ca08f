// Refines the maps of consecutive frames together: links them over time (temporal_link.h), decides
// over the shot which pixels move (shot_segmentation.h) and fits the result to the edges of the
// pictures (edge_refinement.h).
//
//   linked   (TL3) over the frames of the window
//   joined   (SS3) over the frames of a shot; of those before alone where the link is causal
//   steady   joined, linked by (TL3) with a memory of steady_seconds
//   refined  (ER2) of steady at full resolution
//
// The first link determines which pixels move, the second removes flicker of the outlines.
//
// A frame's result depends only on the frames of the window, not on the number of threads.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "vision/masks/edge_refinement.h"
#include "vision/masks/shot_segmentation.h"
#include "vision/masks/temporal_link.h"

namespace egosieve::vision {

struct MapWindowOptions {
  TemporalLinkOptions link;
  double steady_seconds = 0.2;  // positive
  ShotSegmentationOptions shot;

  // How far a frame's result depends on the past and the future: a window needs this margin around
  // the frames to be refined.
  double ReachSeconds() const;
};

// The flow is grown (vision/features/flow_growth.h).
struct WindowFrame : LinkFrame {
  cv::Mat3b full;          // B G R, full resolution; needed if the frame itself is refined
  bool is_linked = false;  // LinkFrames has processed the frame
};

// Frame and map at working resolution. probability: of moving, of the image's size.
WindowFrame MakeWindowFrame(double time_seconds, const cv::Mat3b& image,
                            const cv::Mat1f& probability, bool has_map);

// Fills `flow` of frames[1], ... where that has not been done. It stays empty at a cut
// (vision/matching/one_scene.h), where sizes differ, and for pictures too
// small for flow.
absl::Status LinkFrames(std::vector<WindowFrame>& frames);

// The refined probabilities of frames[first], ..., frames[first + count - 1], which must have
// images.
std::vector<cv::Mat1f> RefineWindow(const std::vector<WindowFrame>& frames, int first, int count,
                                    const MapWindowOptions& options);

}  // namespace egosieve::vision
