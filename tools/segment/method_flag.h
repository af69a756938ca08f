// The flag --method: the segmenter itself, or one of its rivals in its place.
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
  // Whether a method other than a Gaussian process was asked for.
  bool is_rival() const;
  // The two processes are the segmenter with that covariance.
  void Apply(vision::OnlineSegmenterOptions& options) const;
  // InvalidArgument where a rival is to resume a run or to leave maps out: it has no checkpoints.
  absl::Status CheckWith(bool resume, bool leaves_maps) const;

 private:
  std::string name_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_METHOD_FLAG_H_
