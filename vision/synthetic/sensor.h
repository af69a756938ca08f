// Turns radiance into an 8-bit picture.
//
//   (SE1) motion blur  mean of the radiance along the pixel's own path while the shutter is open
//   (SE2) lens         each pixel gives 11 % of its light to each of its four neighbours
//   (SE3) exposure     e = gain * radiance; noise of variance read^2 + shot^2 e, pseudo-Gaussian,
//                      a hash of frame, pixel and channel
//   (SE4) response     1 - exp(-e), then the sRGB curve s, then the contrast of a consumer camera,
//                      0.3 s + 0.7 s^2 (3 - 2 s)
#ifndef EGOSIEVE_VISION_SYNTHETIC_SENSOR_H_
#define EGOSIEVE_VISION_SYNTHETIC_SENSOR_H_

#include <cstdint>
#include <opencv2/core.hpp>

#include "vision/synthetic/scene.h"

namespace egosieve::vision {

// radiance: CV_32FC3, red, green, blue. motion: CV_32FC2, displacement in pixels while the shutter
// is open; empty: no blur. Returns CV_8UC3 in OpenCV's order (blue, green, red).
cv::Mat Expose(const cv::Mat& radiance, const cv::Mat& motion, const SensorSettings& settings,
               double gain, uint32_t seed, int threads);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SYNTHETIC_SENSOR_H_
