// Refined maps of a run's frames, which shares of reconstruct leave for the call that numbers the
// movers.
//
//   refined/NNNNNN.prob.png   value / 65535
//   refined.json              the options that they were made with
//
// Maps made with other options are removed first. A map is complete or absent, so shares may be
// made twice.
#ifndef EGOSIEVE_TOOLS_RECONSTRUCT_REFINED_MAPS_H_
#define EGOSIEVE_TOOLS_RECONSTRUCT_REFINED_MAPS_H_

#include <opencv2/core.hpp>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

class RefinedMaps {
 public:
  // `made_with`: a text that differs for maps that differ.
  RefinedMaps(RunFolder folder, std::string made_with)
      : folder_(std::move(folder)), made_with_(std::move(made_with)) {}

  // Whether there are maps made with the same options.
  bool AreThere() const;
  bool Holds(int64_t index) const;
  absl::StatusOr<cv::Mat1f> Read(int64_t index, cv::Size size) const;

  // Called before the first Write: removes maps made with other options.
  absl::Status Begin() const;
  absl::Status Write(int64_t index, const cv::Mat1f& probability) const;

  absl::Status Remove() const;

 private:
  RunFolder folder_;
  std::string made_with_;
};

// The map after the rounding of Write and Read.
cv::Mat1f RoundedMap(const cv::Mat1f& probability);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RECONSTRUCT_REFINED_MAPS_H_
