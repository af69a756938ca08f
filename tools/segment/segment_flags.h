// The flags of `segment` that shape its output, and the segmenter's options that they make.
//
// A profile sets all options; a flag that is given overrides the profile.
#ifndef EGOSIEVE_TOOLS_SEGMENT_SEGMENT_FLAGS_H_
#define EGOSIEVE_TOOLS_SEGMENT_SEGMENT_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "vision/segmentation/online_segmenter.h"

namespace egosieve::tools {

inline constexpr int kMostFramesAhead = 100;

class SegmentFlags {
 public:
  void AddFlags(CLI::App& app);

  // The profile's options, overridden by the given flags. `threads` is at least 1.
  vision::OnlineSegmenterOptions MakeOptions(int threads) const;

  uint64_t seed() const { return seed_; }
  // By --ahead or --lag.
  bool wants_frames_ahead() const {
    return ahead_.value_or(0) > 0 || lag_seconds_.value_or(0.0) > 0.0;
  }
  // --lag
  std::optional<double> lag_seconds() const { return lag_seconds_; }

 private:
  void AddModelFlags(CLI::App& app);
  void AddLabelFlags(CLI::App& app);
  void AddLearnerFlags(CLI::App& app);

  std::string profile_ = "default";
  uint64_t seed_ = 1;
  std::optional<int> stride_;
  std::optional<int> window_;
  std::optional<std::string> model_;
  std::optional<int64_t> budget_;
  std::optional<double> density_;
  std::optional<double> contradiction_radius_;
  std::optional<int64_t> dynamic_age_;
  std::optional<double> arrival_share_;
  std::optional<double> location_prior_;
  std::optional<double> label_residual_;
  bool potential_ = false;
  std::optional<int64_t> inducing_points_;
  std::optional<std::string> frame_gap_;
  std::optional<int> labelling_size_;
  std::optional<std::string> patch_search_;
  std::optional<double> focal_ratio_;
  std::optional<int> ahead_;
  std::optional<double> lag_seconds_;
  std::optional<std::string> evidence_;
  std::optional<std::string> equalize_;
  std::optional<std::string> covariance_;
  std::optional<std::string> novelty_filter_;
  std::optional<std::string> consistency_filter_;
  std::optional<std::string> zero_label_;
};

// Every flag of SegmentFlags with the value of its option. Runs with the same options have the same
// map, whether a value was given or came from the profile.
std::map<std::string, std::string> DescribeOptions(const vision::OnlineSegmenterOptions& options);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_SEGMENT_FLAGS_H_
