// Pieces of synthetic drives with their truth, and how labels do on them.
#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "vision/frame/frame.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/synthetic/street.h"

namespace egosieve::vision {

// A frame, and 255 in `movers` where it shows something that moves.
struct DrivePicture {
  Frame frame;
  cv::Mat movers;
};

// A scenario of the catalogue, 400 x 240, its scene changed by `edit`.
Scenario EditedScenario(const std::string& name, uint64_t seed,
                        const std::function<void(Scene&)>& edit);

// In picture widths.
double FocalRatioOf(const Scenario& scenario);
// As a first pass over the drive would tell it: the direction from frame `first` to the next.
TravelPrior TravelOf(const Scenario& scenario, int first = 20);

// Frames first .. first + count - 1 of the scenario, their own indices kept.
std::vector<DrivePicture> PicturesOf(const Scenario& scenario, int first, int count);

// The same seen through a shutter that opens row by row: the last row `readout_seconds` after the
// first, the middle row at the frame's time. What is hidden from the one instant is missing: each
// pixel is taken from where its row's instant has it by depth, pose and its object's velocity.
std::vector<DrivePicture> RollingPicturesOf(const Scenario& scenario, int first, int count,
                                            double readout_seconds);

struct LabelCounts {
  int64_t standing = 0, false_alarms = 0;  // probability above 1/2
  int64_t moving = 0, found = 0;

  void Add(const LabelCounts& other);
  double FalseShare() const;
  double FoundShare() const;
};

// Labels against the truth; places within two pixels of a mover's outline count as neither.
LabelCounts Count(const LabelledFrame& labels, const cv::Mat& movers);

// The last picture's labels, of a labeller that was shown all.
LabelledFrame LastLabels(const FrameLabellerOptions& options,
                         const std::vector<DrivePicture>& pictures);

}  // namespace egosieve::vision
