// Joins over time what the tracker (mover_tracker.h) saw of the movers, a chunk of frames at once.
//
//   piece   the sightings with one number of the tracker, in consecutive frames
//   place   of a mover: its centre less the way of the static scene since the first frame, the sum
//           of the medians of its flow. So a camera that shakes or turns moves no mover      (ML1)
//   end     of a piece, its first or its last: place x, speed v, pixels n and colours h of the
//           sighting there; all but x are means with the weights exp(-dt / kEndSeconds)
//   cost    of piece b, which begins dt <= kLostSeconds after a has ended, as a's mover:
//           (|x_a + v dt - x_b| / R)^2 + (|v_a - v_b| / S)^2 + (B(h_a, h_b) / kColours)^2
//           + ln(n_a / n_b)^2 / 2;   v = (v_a + v_b) / 2,
//           R = sqrt(max(n_a, n_b)) + kPlaceShare |v| dt + 1,
//           S = kSpeedNoise + kSpeedShare max(|v_a|, |v_b|),  B Bhattacharyya's distance     (ML2)
//
// Pairs (a, b) are joined in the order of their costs, up to kMostCost. A piece follows at most one
// other and is followed by at most one. What follows none is a new mover.
//
// Places are in pixels of the working resolution, speeds in these per second. The result depends on
// the chunks, and not on whether a run was resumed between them.
//
// References: Huang, Wu & Nevatia, Robust object tracking by hierarchical association of detection
// responses (2008).
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/masks/mover_tracker.h"
#include "vision/masks/pixel_assignment.h"

namespace egosieve::vision {

inline constexpr double kLostSeconds = 1.5;

// One number of the tracker in one frame.
struct Sighting {
  uint16_t number = 0;
  double time_seconds = 0.0;
  cv::Point2d centre;
  double pixels = 0.0;
  // Speed against the static scene, since the frame before and to the next one.
  std::optional<cv::Point2d> arriving, leaving;
  ColourShares colours = {};
};

struct SightedFrame {
  double time_seconds = 0.0;
  cv::Point2d shift;  // of the static scene since the frame before, pixels
  std::vector<Sighting> sightings;
};

// Of frames[now], in which the movers have these numbers. Nothing is taken from later frames where
// `causal`.
SightedFrame SightingsOf(const std::vector<TrackedFrame>& frames, size_t now,
                         const cv::Mat1w& numbers, bool causal);

class MoverLinks {
 public:
  // The next frames' sightings. Returns for each frame the
  // mover's number of each number of the tracker: 1 to 65535, then again from 1.
  std::vector<std::map<uint16_t, uint16_t>> Add(const std::vector<SightedFrame>& frames);

  std::string ToText() const;
  // DataLoss if the text is damaged.
  static absl::StatusOr<MoverLinks> Restore(absl::string_view text);

 private:
  struct End {
    double time_seconds = 0.0;
    cv::Point2d place;
    std::optional<cv::Point2d> speed;
    double pixels = 0.0;
    ColourShares colours = {};
  };
  struct Piece {
    uint16_t mover = 0;   // 0: not known yet
    uint16_t number = 0;  // the tracker's
    End first, last;
  };
  struct Join {
    double cost = 0.0;
    size_t before = 0, after = 0;
  };

  static void Extend(const Sighting& sighting, cv::Point2d shift,
                     const std::optional<cv::Point2d>& speed, End& end);
  static std::optional<double> CostOf(const Piece& before, const Piece& after);  // (ML2)
  std::vector<Piece> PiecesOf(const std::vector<SightedFrame>& frames,
                              std::vector<std::map<uint16_t, size_t>>* piece_of);
  void JoinPieces(std::vector<Piece>& pieces);
  uint16_t NewNumber(const std::vector<Piece>& pieces);

  double last_seconds_ = 0.0;  // of the last frame
  cv::Point2d shift_;          // of the static scene since the first frame
  std::vector<Piece> open_;    // pieces that may go on or be followed
  int next_number_ = 1;
};

}  // namespace egosieve::vision
