// Movers told apart and numbered, frame by frame.
//
//   prediction  each pixel of the mask takes the number that its place had in the frame before, by
//               flow, where flow and its return agree                                         (M1)
//   regions     connected regions of the mask; pixels without a prediction take the nearest
//               number of their region, but for large pieces whose flow differs from that
//               number's; so movers that come to touch stay apart                            (M2)
//   new         a region without a prediction, or such a piece: a mover that was lost for at most
//               lost_seconds, where place, size and colours agree, else a new number         (M3)
//   split       a mover that for split_votes frames in a row moves as two (motion_split.h), or
//               lies in two large pieces: the smaller part goes with a mover that it touches
//               and that has its motion and colours, else as (M3)                           (M4)
//
// Numbers run from 1 to 65535 and begin anew after that. Specks of fewer than min_pixels that
// nobody predicts are no movers.
//
// A tracker that was restored from its text goes on to the last bit.
#ifndef EGOSIEVE_VISION_MASKS_MOVER_TRACKER_H_
#define EGOSIEVE_VISION_MASKS_MOVER_TRACKER_H_

#include <array>
#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/features/flow_grid.h"

namespace egosieve::vision {

struct MoverTrackerOptions {
  int min_pixels = 24;         // of working resolution
  double lost_seconds = 1.5;   // >= 0
  int split_votes = 3;         // positive
  double min_piece = 0.25;     // of the larger piece, for (M4)
  double max_distance = 0.45;  // Bhattacharyya's, between colours, for (M3)

  absl::Status Validate() const;
};

class MoverTracker {
 public:
  explicit MoverTracker(const MoverTrackerOptions& options) : options_(options) {}

  // The next frame, all at one working resolution. mask: non-zero where it moves. flow: from the
  // frame before to this one; empty where there is none. Returns the numbers of the movers, 0
  // elsewhere.
  cv::Mat1w Add(double time_seconds, const cv::Mat3b& image, const cv::Mat1b& mask,
                const FlowPair& flow);

  std::string ToText() const;
  // DataLoss where the text is damaged.
  static absl::StatusOr<MoverTracker> Restore(const MoverTrackerOptions& options,
                                              absl::string_view text);

 private:
  static constexpr int kColours = 64;

  struct Mover {
    double last_seconds = 0.0;  // when it was seen
    cv::Point2d centre, speed;  // pixels, pixels a second
    double pixels = 0.0;
    std::array<double, kColours> colours = {};  // shares
    int votes = 0;                              // (M4)
  };

  cv::Mat1w Predict(const cv::Mat1b& mask, const FlowPair& flow) const;  // (M1)
  cv::Mat1w FillRegions(const cv::Mat3b& image, const cv::Mat1b& mask, double time_seconds,
                        const FlowPair& flow, cv::Mat1w numbers);  // (M2), (M3)
  uint16_t NumberFor(const Mover& seen, const cv::Mat1w& numbers, double time_seconds);  // (M3)
  uint16_t NumberOfPart(const Mover& seen, const cv::Mat1b& part, uint16_t whole,
                        const FlowPair& flow, const cv::Mat1w& numbers);
  void SplitMovers(double time_seconds, const cv::Mat3b& image, const FlowPair& flow,
                   cv::Mat1w& numbers);  // (M4)
  void Remember(double time_seconds, const cv::Mat3b& image, const cv::Mat1w& numbers);
  uint16_t NewNumber();
  static Mover Describe(const cv::Mat3b& image, const cv::Mat1b& region, double time_seconds);

  MoverTrackerOptions options_;
  cv::Mat1w last_;
  std::map<uint16_t, Mover> movers_;
  int next_number_ = 1;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MASKS_MOVER_TRACKER_H_
