#include "tools/masks/coverage.h"

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluation/roc.h"

namespace egosieve::tools {
absl::StatusOr<Coverage> Coverage::Open(const std::string& truth, const std::string& input,
                                        cv::Size first_size) {
  Coverage coverage;
  if (truth.empty()) return coverage;
  EGOSIEVE_ASSIGN_OR_RETURN(coverage.truth_,
                            ListTruthMasks(truth, FrameNames(input), MatchMasks::kAuto));
  const auto first = coverage.truth_.paths.find(0);
  if (first != coverage.truth_.paths.end()) {
    EGOSIEVE_RETURN_IF_ERROR(ReadTruthMask(first->second, first_size).status());
  }
  return coverage;
}

absl::Status Coverage::Add(int64_t index, const cv::Mat1b& masked) {
  const auto path = truth_.paths.find(index);
  if (path == truth_.paths.end()) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1b truth, ReadTruthMask(path->second, masked.size()));
  const cv::Mat1b moving = truth == kTruthDynamic, rest = truth == kTruthStatic;
  moving_ += cv::countNonZero(moving);
  moving_masked_ += cv::countNonZero(moving & masked);
  rest_ += cv::countNonZero(rest);
  rest_masked_ += cv::countNonZero(rest & masked);
  ++frames_;
  return absl::OkStatus();
}

double Coverage::MovingMasked() const { return Ratio(moving_masked_, moving_).value_or(0.0); }

double Coverage::RestMasked() const { return Ratio(rest_masked_, rest_).value_or(0.0); }

std::string Coverage::Describe() const {
  return absl::StrFormat("masked: %.3f of what moves, %.3f of the rest, in %d frames",
                         MovingMasked(), RestMasked(), frames_);
}

}  // namespace egosieve::tools
