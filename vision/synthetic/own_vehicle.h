// The parts of the own vehicle that a camera behind a windscreen sees. They are fixed in the image.
// s = 2 x / (w - 1) - 1 for pixels (x, y) of an image of w x h.
//
//   (SO1) bonnet     y >= h (1 - b (1 - s^2 / 3)): painted metal
//   (SO2) bracket    a dark wedge at the right border, from the bonnet up to the middle
//   (SO3) reflection L' = (1 - m / 4) L + r m: soft bright patches m in [0, 1] of the dashboard in
//                    the windscreen, which does not hide the world
//   (SO4) stamp      date and time, changing once per second, written into the upper left corner of
//                    the picture
//
// Pixels of bonnet, bracket and the stamp's box belong to the own vehicle; those of the reflection
// belong to the world.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace egosieve::vision {

struct OwnVehicleStyle {
  bool visible = false;
  double bonnet = 0.15;      // b, share of the image's height
  double reflection = 0.35;  // r, radiance
  uint32_t seed = 0;
};

class OwnVehicle {
 public:
  OwnVehicle(const OwnVehicleStyle& style, cv::Size size);

  // CV_8UC1: 255 at the own vehicle's pixels, else 0.
  const cv::Mat& mask() const { return mask_; }
  // (SO1) to (SO3). radiance: CV_32FC3, red, green, blue.
  void Cover(cv::Mat* radiance) const;
  // (SO4). image: CV_8UC3.
  void Stamp(double seconds, cv::Mat* image) const;

 private:
  OwnVehicleStyle style_;
  cv::Size size_;
  double scale_;  // of the stamp's letters
  int thickness_;
  cv::Rect stamp_;
  cv::Mat mask_;
  cv::Mat reflection_;  // m, CV_32FC1
};

}  // namespace egosieve::vision
