#include "vision/masks/glimpses.h"

namespace egosieve::vision {

void DropGlimpses(const std::vector<uint16_t>& first_seen, const cv::Mat1w& next,
                  cv::Mat1w& numbers) {
  for (const uint16_t number : first_seen) {
    if (cv::countNonZero(next == number) > 0) continue;
    const cv::Mat1b place = numbers == number;
    if (2 * cv::countNonZero(place & (next != 0)) < cv::countNonZero(place)) {
      numbers.setTo(0, place);
    }
  }
}

}  // namespace egosieve::vision
