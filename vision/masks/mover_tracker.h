// Separates movers and follows them from frame to frame. mover_links.h joins what this loses.
//
//   known       a pixel of the mask takes the mover of the previous frame that explains it best
//               (pixel_assignment.h), each mover with a motion of its own                     (M1)
//   regions     pixels that no mover explains join a mover of their region with similar motion,
//               the nearest one where too little is known of their motion, or are new         (M2)
//   split       a mover whose cells have two motions (motion_split.h) within kLookSeconds: the
//               smaller part joins a mover that it touches and moves with, or is new          (M3)
//   fragments   of fewer than 8 kMinMoverPixels join the mover that they touch                (M4)
//
// Numbers run from 1 to 65535 and then start again. Specks of fewer than kMinMoverPixels that no
// mover explains are not movers.
//
// A tracker that was restored from its text continues with identical results.
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/features/flow_grid.h"
#include "vision/masks/moving_cells.h"
#include "vision/masks/pixel_assignment.h"
#include "vision/masks/temporal_link.h"

namespace egosieve::vision {

inline constexpr int kMinMoverPixels = 24;  // at working resolution
inline constexpr double kLookSeconds = 0.5;

// Removes movers that a single frame shows.
//
//   glimpse   a mover that is first seen in a frame and not in the next one, at most
//             kGlimpseSeconds later, where less than half of its place belongs to others      (MG1)
//
// So a glimpse is an error of the map: what moves is in view for twice as long. A view of 70
// degrees is 7 m wide at a distance of 5 m, which a car of 4 m crosses in 0.5 s at 22 m/s.
//
// first_seen: numbers first seen in the frame of `numbers`; next: the numbers of the next frame.
inline constexpr double kGlimpseSeconds = 0.25;
void DropGlimpses(const std::vector<uint16_t>& first_seen, const cv::Mat1w& next,
                  cv::Mat1w& numbers);

class MoverTracker {
 public:
  // Adds the next frame, frames[now]. mask: non-zero where it moves. The frames after it show which
  // movers will separate; without any, the frames before it show which have separated. Returns the
  // numbers of the movers, 0 elsewhere.
  cv::Mat1w Add(const std::vector<TrackedFrame>& frames, size_t now, const cv::Mat1b& mask);

  // Numbers that the last frame was the first to show.
  std::vector<uint16_t> SeenOnce() const;

  std::string ToText() const;
  // DataLoss if the text is damaged.
  static absl::StatusOr<MoverTracker> Restore(absl::string_view text);

 private:
  struct Mover {
    bool is_new = true;
    cv::Point2d centre, speed;  // pixels, pixels per second
    ColourShares colours = {};
  };
  struct Scene;

  cv::Mat1w AssignKnown(const Scene& scene) const;           // (M1)
  void FillRegions(const Scene& scene, cv::Mat1w& numbers);  // (M2)
  void SplitMovers(const Scene& scene, cv::Mat1w& numbers);  // (M3)
  uint16_t NumberOfPart(const Scene& scene, const cv::Mat1b& part, uint16_t whole,
                        const cv::Mat1w& numbers);
  static std::optional<std::pair<double, uint16_t>> NearestMotion(
      const Scene& scene, const cv::Mat1b& piece, const std::map<uint16_t, int>& among,
      const cv::Mat1w& numbers);
  static void DropFragments(cv::Mat1w& numbers);  // (M4)
  void Remember(const Scene& scene, const cv::Mat1w& numbers);
  uint16_t NewNumber(const cv::Mat1w& numbers);
  static Mover Describe(const Scene& scene, const cv::Mat1b& region);

  cv::Mat1w last_;
  std::map<uint16_t, Mover> movers_;
  int next_number_ = 1;
};

}  // namespace egosieve::vision
