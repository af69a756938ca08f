// Separates movers and numbers them, frame by frame.
//
//   known       a pixel of the mask takes the mover of the previous frame that explains it best
//               (pixel_assignment.h), each mover with a motion of its own; a piece of a mover that
//               lies apart from its largest piece (stray_pieces.h) loses the number           (M1)
//   regions     pixels that no mover explains join a mover of their region with similar motion,
//               the nearest one where too little is known of their motion, or are new         (M2)
//   new         takes the number of a mover that was lost for at most lost_seconds, where position,
//               size and colours agree, else a new number                                     (M3)
//   split       a mover whose cells have two motions (motion_split.h) within look_seconds: the
//               smaller part joins a mover that it touches and moves with, else (M3) applies; a
//               part that moves like the static scene around it, such as the road in front of a
//               car, loses its number                                                         (M4)
//   merge       two movers that touch, have moved as one for merge_votes frames, and were never
//               apart become one, with the number of the older                                (M5)
//   fragments   of fewer than 8 min_pixels join the mover that they touch                     (M6)
//
// Numbers run from 1 to 65535 and then start again. Specks of fewer than min_pixels that no mover
// explains are not movers.
//
// A tracker that was restored from its text continues with identical results.
#pragma once

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
  int min_pixels = 24;         // at working resolution
  double lost_seconds = 1.5;   // >= 0
  double look_seconds = 0.5;   // positive
  int merge_votes = 3;         // positive
  double max_distance = 0.45;  // Bhattacharyya's, between colours, for (M3)

  absl::Status Validate() const;
};

// All frames have the same working resolution.
struct TrackedFrame {
  double time_seconds = 0.0;
  cv::Mat3b image;
  FlowPair flow;  // from the previous frame to this one; empty: none
};

class MoverTracker {
 public:
  explicit MoverTracker(const MoverTrackerOptions& options) : options_(options) {}

  // Adds the next frame, frames[now]. mask: non-zero where it moves. The frames after it show which
  // movers will separate; without any, the frames before it show which have separated. Returns the
  // numbers of the movers, 0 elsewhere.
  cv::Mat1w Add(const std::vector<TrackedFrame>& frames, size_t now, const cv::Mat1b& mask);

  // Numbers of movers not lost for long that one frame alone has shown.
  std::vector<uint16_t> SeenOnce() const;

  std::string ToText() const;
  // DataLoss if the text is damaged.
  static absl::StatusOr<MoverTracker> Restore(const MoverTrackerOptions& options,
                                              absl::string_view text);

 private:
  struct Mover {
    double first_seconds = 0.0, last_seconds = 0.0;  // first and last time seen
    cv::Point2d centre, speed;                       // pixels, pixels per second
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
  std::map<std::pair<uint16_t, uint16_t>, int> votes_;  // (M5): a mover and one that it touches
  std::set<std::pair<uint16_t, uint16_t>> apart_;       // (M5), the smaller number first
  int next_number_ = 1;
};

}  // namespace egosieve::vision
