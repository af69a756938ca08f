// How many labelled boxes a map marks, by class, motion and distance, and which share of the area
// outside all boxes it marks.
//
//   (BX1) m = mean over the pixels of the box's middle of p, interpolated linearly; the middle is
//        the rectangle about the box's centre with `middle` of each of its sides, clipped to the
//        image
//   (BX2) a box is marked where m >= threshold
//   (BX3) outside = pixels of the map in no box at all; marked outside = of these, p >= threshold
//
// Some boxes are left out of (BX2), but not of (BX3): boxes that are largely truncated or largely
// occluded (levels of box_truth.h above those of the options), and boxes with unknown motion,
// unknown class, or a middle outside the image.
#ifndef EGOSIEVE_TOOLS_EVALUATION_BOX_SCORES_H_
#define EGOSIEVE_TOOLS_EVALUATION_BOX_SCORES_H_

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "kernels/base/image_grid.h"
#include "tools/evaluation/box_truth.h"

namespace egosieve::tools {

struct BoxScoresOptions {
  double threshold = 0.5;
  double middle = 0.6;     // of each side, in (0, 1]
  int most_truncated = 1;  // largest level of a box that counts
  int most_occluded = 1;   // the same for occlusion

  absl::Status Validate() const;
};

struct BoxCount {
  int64_t boxes = 0;
  int64_t marked = 0;
};

// (BX1); negative if the middle lies outside the image.
double MeanInMiddle(const LabelledBox& box, const cv::Mat1f& probability,
                    const kernels::ImageGrid& grid, double middle);

class BoxScores {
 public:
  explicit BoxScores(const BoxScoresOptions& options = {}) : options_(options) {}

  // One frame: its boxes and its map at the grid's pixels.
  void Add(const std::vector<LabelledBox>& boxes, const cv::Mat1f& probability,
           const kernels::ImageGrid& grid);
  void Merge(const BoxScores& other);

  int64_t frames() const { return frames_; }
  // Boxes of "moving vehicle", "standing person" and so on, at one of kBoxDistances or at "all".
  BoxCount Of(const std::string& kind, const std::string& distance) const;
  int64_t left_out() const { return left_out_; }
  // (BX3); 0 if no pixel is outside.
  double OutsideShare() const;

  nlohmann::ordered_json ToJson() const;
  // One row per kind, one column per distance present, and one line for the area outside.
  std::string ToTable() const;

 private:
  BoxScoresOptions options_;
  std::map<std::pair<std::string, std::string>, BoxCount> counts_;  // by kind and distance
  int64_t frames_ = 0;
  int64_t left_out_ = 0;
  int64_t outside_pixels_ = 0;
  int64_t outside_marked_ = 0;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_BOX_SCORES_H_
