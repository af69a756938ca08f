// The front end of the paper's section III, for profile `paper`.
//
//   1. grey, equalised picture                              vision/frame/equalization.h
//   2. SIFT key points and corners of the frame             feature_extractor.h
//   3. matches with the frame `frame_gap` before            feature_matcher.h
//   4. fundamental matrix by RANSAC                         fundamental_fit.h
//   5. distance d of each match to its epipolar line gives
//      its probability of belonging to a mover, p = d / 3 px;
//      larger d are false matches and get no label
//
// Labels are places in the first frame of the pair. The paper names no largest distance. The state
// is the frames alone.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {

struct PaperFrame;

class PaperLabeller : public FrameLabeller {
 public:
  // Options of the flow grid, evidence and the camera are not used.
  static absl::StatusOr<std::unique_ptr<FrameLabeller>> Create(const FrameLabellerOptions& options);

  absl::StatusOr<std::shared_ptr<const ExtractedFrame>> Extract(const Frame& frame) const override;
  absl::Status Prepare(const ExtractedFrame&, const ExtractedFrame&) const override {
    return absl::OkStatus();
  }
  // ahead: not used.
  absl::StatusOr<LabelledFrame> Label(
      std::shared_ptr<const ExtractedFrame> frame,
      const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead) override;
  absl::Status Prime(const Frame& frame) override;
  LearntCamera learnt_camera() const override { return LearntCamera(); }
  std::string state() const override;
  absl::Status Restore(absl::string_view state) override;
  const FrameLabellerOptions& options() const override { return options_; }

 private:
  explicit PaperLabeller(const FrameLabellerOptions& options) : options_(options) {}

  absl::Status LabelPair(const PaperFrame& first, const PaperFrame& second,
                         LabelledFrame& result) const;

  FrameLabellerOptions options_;
  std::deque<std::shared_ptr<const PaperFrame>> history_;  // at most frame_gap, oldest first
};

}  // namespace egosieve::vision
