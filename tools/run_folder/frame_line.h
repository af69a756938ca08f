// The record of one frame: a line of frames.jsonl.
//
// All fields except `milliseconds` depend only on input, flags, device and build: without it, the
// lines of two runs are equal in every byte.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/segmentation/frame_record.h"
#include "vision/trajectory/camera_step.h"

namespace egosieve::tools {

struct FrameLine {
  enum class Outcome {
    kLearnt,    // the model learnt from the pair that ends in this frame
    kAnswered,  // the frame has its map, but nothing was learnt from it: `reason` says why
    kFailed,    // the frame could not be read: its map, if any, is that of the frame before it;
                // `reason` says why
  };

  int64_t index = 0;  // in the input, from 0
  // The picture's name (FrameSource::image_name), read from a log as in json_name.h.
  std::string image;
  double time_seconds = 0.0;
  Outcome outcome = Outcome::kAnswered;
  std::string reason;    // empty where learnt
  std::string doubt;     // why the frame is unreliable; empty if it is reliable
  int width_pixels = 0;  // of the frame; may differ between frames; 0: it has no map
  int height_pixels = 0;

  int64_t features = 0;
  int64_t matches = 0;
  std::string motion_model = "none";  // none, static, homography or fundamental; a calibrated
                                      // motion is one of the last three
  int64_t inliers = 0;                // of the motion model
  double noise_pixels = 0.0;          // scale of the static features' residuals
  int64_t labelled_static = 0;        // p < 1/2
  int64_t labelled_dynamic = 0;       // p >= 1/2
  int64_t frame_gap = 0;              // frames between the two pictures of the pair; 0: no pair
  // Shares of the dynamic labels by their strongest evidence; names of vision/evidence/fusion.h.
  std::vector<std::pair<std::string, double>> decided_by;  // shares

  vision::CameraStep step;  // motion of the camera since the frame before

  vision::SelectionCounts points;
  int64_t model_size = 0;     // points, after this frame; 0: the map is the prior
  std::vector<double> theta;  // logarithms: scales..., sigma_f, sigma_n
  double a = 1.0;             // of p = Phi((a mean + b) / sqrt(1 + a^2 variance))
  double b = 0.0;
  double log_likelihood_per_point = 0.0;  // of the training subset; 0 where no step was taken
  bool factor_rebuilt = false;
  double jitter = 0.0;         // added to the noise variance so that the factor exists
  double dynamic_share = 0.0;  // share of the grid's pixels with a probability of 1/2 or more
  // Intersection over union of the map's mask with the true one, expected by the map's own
  // probabilities; NaN: no map.
  double expected_overlap = std::numeric_limits<double>::quiet_NaN();
  int64_t clamped_variances = 0;     // negative from rounding, set to 0
  int64_t saturated_deviations = 0;  // above full scale in the deviation map
  std::string map_device;            // that made the map; empty, in the log absent: the run's

  bool has_map() const { return width_pixels > 0; }

  // Stages and their times, in the order in which the stages ran.
  std::vector<std::pair<std::string, double>> milliseconds;
};

nlohmann::ordered_json ToJson(const FrameLine& line);
// DataLoss, naming the field, if a field is missing or has another type.
absl::StatusOr<FrameLine> FrameLineFromJson(const nlohmann::ordered_json& json);

// One line, without its line break. Numbers that are not finite are written as null and read as
// NaN.
std::string ToText(const FrameLine& line);
absl::StatusOr<FrameLine> FrameLineFromText(absl::string_view line);

}  // namespace egosieve::tools
