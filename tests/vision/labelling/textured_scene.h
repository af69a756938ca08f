// Pictures that show something, and labellers for them.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/frame/frame.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {

inline constexpr int kWidth = 240, kHeight = 160;

// Blurred noise: texture at several scales.
cv::Mat Texture(int width, int height, uint64_t seed);

// A wide textured wall seen by a camera that turns 3 pixels a frame, and a square that moves
// against it.
Frame WallFrame(int64_t index);
// 255 on the square.
cv::Mat WallMask(int64_t index);

Frame FrameOf(int64_t index, const cv::Mat& image);

// The default, with a known focal length, too, and the paper's front end.
std::vector<FrameLabellerOptions> EveryKindOfOptions();

std::unique_ptr<FrameLabeller> MakeLabeller(const FrameLabellerOptions& options);

}  // namespace egosieve::vision
