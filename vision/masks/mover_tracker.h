// Movers told apart and numbered, frame by frame.
//
//   known       a pixel of the mask takes the mover of the frame before that explains it best
//               (pixel_assignment.h), each carried by a motion of its own; a piece of it that is
//               apart from its largest (stray_pieces.h) loses the number                      (M1)
//   regions     what no mover explains goes with a mover of its region that moves alike, else with
//               the nearest where too little is known of its motion, else it is new           (M2)
//   new         a mover that was lost for at most lost_seconds, where place, size and colours
//               agree, else a new number                                                      (M3)
//   split       a mover whose cells move as two (motion_split.h) within look_seconds: the smaller
//               part goes with a mover that it touches and moves with, else as (M3); what moves as
//               the world around it, such as the road before a car, is no mover              (M4)
//   merge       two that touch, for merge_votes frames move as one, and were never apart, are the
//               older of the two (M5)
//   fragments   of fewer than 8 min_pixels go with the mover that they touch                  (M6)
//
// Numbers run from 1 to 65535 and begin anew after that. Specks of fewer than min_pixels that
// nobody explains are no movers.
//
// A tracker that was restored from its text goes on to the last bit.
#ifndef EGOSIEVE_VISION_MASKS_MOVER_TRACKER_H_
#define EGOSIEVE_VISION_MASKS_MOVER_TRACKER_H_

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/features/flow_grid.h"
#include "vision/masks/moving_cells.h"
#include "vision/masks/pixel_assignment.h"

namespace egosieve::vision {

struct MoverTrackerOptions {
  int min_pixels = 24;         // of working resolution
  double lost_seconds = 1.5;   // >= 0
  double look_seconds = 0.5;   // positive
  int merge_votes = 3;         // positive
  double max_distance = 0.45;  // Bhattacharyya's, between colours, for (M3)

  absl::Status Validate() const;
};

// At one working resolution.
struct TrackedFrame {
  double time_seconds = 0.0;
  cv::Mat3b image;
  FlowPair flow;  // from the frame before to this one, not grown; empty where there is none
};

class MoverTracker {
 public:
  explicit MoverTracker(const MoverTrackerOptions& options) : options_(options) {}

  // The next frame, frames[now]. mask: non-zero where it moves. Frames after it show movers that
  // will part; without any, those before it show those that have. Returns the numbers of the
  // movers, 0 elsewhere.
  cv::Mat1w Add(const std::vector<TrackedFrame>& frames, size_t now, const cv::Mat1b& mask);

  std::string ToText() const;
  // DataLoss where the text is damaged.
  static absl::StatusOr<MoverTracker> Restore(const MoverTrackerOptions& options,
                                              absl::string_view text);

 private:
  struct Mover {
    double first_seconds = 0.0, last_seconds = 0.0;  // when it was seen
    cv::Point2d centre, speed;                       // pixels, pixels a second
    double pixels = 0.0;
    ColourShares colours = {};
  };
  struct Scene;

  cv::Mat1w AssignKnown(const Scene& scene) const;                  // (M1)
  void FillRegions(const Scene& scene, cv::Mat1w& numbers);         // (M2)
  uint16_t NumberFor(const Mover& seen, const cv::Mat1w& numbers);  // (M3)
  void SplitMovers(const Scene& scene, cv::Mat1w& numbers);         // (M4)
  uint16_t NumberOfPart(const Scene& scene, const cv::Mat1b& part, uint16_t whole,
                        const cv::Mat1w& numbers);
  static bool MovesAsWorld(const Scene& scene, const cv::Mat1b& part);
  static std::optional<std::pair<double, uint16_t>> NearestMotion(
      const Scene& scene, const cv::Mat1b& piece, const std::map<uint16_t, int>& among,
      const cv::Mat1w& numbers);
  void RememberApart(const Scene& scene, const cv::Mat1w& numbers);
  void MergeMovers(const Scene& scene, cv::Mat1w& numbers);  // (M5)
  uint16_t PartnerOf(const Scene& scene, uint16_t number, const cv::Mat1w& numbers);
  void DropFragments(cv::Mat1w& numbers) const;  // (M6)
  void Remember(const Scene& scene, const cv::Mat1w& numbers);
  uint16_t NewNumber();
  static Mover Describe(const Scene& scene, const cv::Mat1b& region);

  MoverTrackerOptions options_;
  cv::Mat1w last_;
  std::map<uint16_t, Mover> movers_;
  std::map<std::pair<uint16_t, uint16_t>, int> votes_;  // (M5), the smaller mover first
  std::set<std::pair<uint16_t, uint16_t>> apart_;       // (M5), the smaller number first
  int next_number_ = 1;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MASKS_MOVER_TRACKER_H_
