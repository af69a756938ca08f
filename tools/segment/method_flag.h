// The flag --method: the segmenter itself, or one of the methods to compare with.
#ifndef EGOSIEVE_TOOLS_SEGMENT_METHOD_FLAG_H_
#define EGOSIEVE_TOOLS_SEGMENT_METHOD_FLAG_H_

#include <CLI/CLI.hpp>
#include <string>

#include "absl/status/status.h"
#include "vision/segmentation/online_segmenter.h"

namespace egosieve::tools {

class MethodFlag {
 public:
  void AddFlag(CLI::App& app);

  const std::string& name() const { return name_; }  // empty: not given
  // Whether a method other than a Gaussian process was requested.
  bool is_rival() const;
  // The two Gaussian process methods are the segmenter with the covariance of that name.
  void Apply(vision::OnlineSegmenterOptions& options) const;
  // InvalidArgument if another method is to resume a run or to leave out maps: it has no
  // checkpoints.
  absl::Status CheckWith(bool resume, bool leaves_maps) const;

 private:
  std::string name_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_METHOD_FLAG_H_
