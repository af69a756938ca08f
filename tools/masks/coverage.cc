#include "tools/masks/coverage.h"

#include <algorithm>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/masks/truth_masks.h"

namespace egosieve::tools {
namespace {

double Share(int64_t part, int64_t whole) {
  return static_cast<double>(part) / static_cast<double>(std::max<int64_t>(whole, 1));
}

}  // namespace

absl::StatusOr<Coverage> Coverage::Open(const std::string& truth, const std::string& input,
                                        cv::Size first_size) {
  Coverage coverage;
  if (truth.empty()) return coverage;
  EGOSIEVE_ASSIGN_OR_RETURN(coverage.truth_, ListTruthMasks(truth, FrameNames(input)));
  const auto first = coverage.truth_.find(0);
  if (first != coverage.truth_.end()) {
    EGOSIEVE_RETURN_IF_ERROR(ReadTruthMask(first->second, first_size).status());
  }
  return coverage;
}

absl::Status Coverage::Add(int64_t index, const cv::Mat1b& masked) {
  const auto path = truth_.find(index);
  if (path == truth_.end()) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1b truth, ReadTruthMask(path->second, masked.size()));
  const cv::Mat1b moving = truth == kTruthDynamic, rest = truth == kTruthStatic;
  moving_ += cv::countNonZero(moving);
  moving_masked_ += cv::countNonZero(moving & masked);
  rest_ += cv::countNonZero(rest);
  rest_masked_ += cv::countNonZero(rest & masked);
  ++frames_;
  return absl::OkStatus();
}

double Coverage::MovingMasked() const { return Share(moving_masked_, moving_); }

double Coverage::RestMasked() const { return Share(rest_masked_, rest_); }

std::string Coverage::Describe() const {
  return absl::StrFormat("masked: %.3f of what moves, %.3f of the rest, in %d frames",
                         MovingMasked(), RestMasked(), frames_);
}

}  // namespace egosieve::tools
