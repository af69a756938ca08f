// Labels of a recording of several shots: each has a labeller of its own, with its camera.
//
// Nothing of one shot is used for the labels of another. Only the labellers of the current shot and of
// those whose frames were extracted ahead are kept.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {

class ShotLabeller : public FrameLabeller {
 public:
  // options: of the first shot, with those of the others in later_shots.
  static absl::StatusOr<std::unique_ptr<FrameLabeller>> Create(const FrameLabellerOptions& options);

  absl::StatusOr<std::shared_ptr<const ExtractedFrame>> Extract(const Frame& frame) const override;
  absl::Status Prepare(const ExtractedFrame& first, const ExtractedFrame& second) const override;
  absl::StatusOr<LabelledFrame> Label(
      std::shared_ptr<const ExtractedFrame> frame,
      const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead) override;
  absl::Status Prime(const Frame& frame) override;
  LearntCamera learnt_camera() const override { return {}; }
  // The number of the current shot, and its labeller's state.
  std::string state() const override;
  absl::Status Restore(absl::string_view state) override;
  const FrameLabellerOptions& options() const override { return options_; }

 private:
  explicit ShotLabeller(const FrameLabellerOptions& options)
      : options_(options), labellers_(options.later_shots.size() + 1) {}

  const FrameLabellerOptions& OptionsOf(size_t shot) const {
    return shot == 0 ? options_ : options_.later_shots[shot - 1];
  }
  size_t ShotOf(int64_t frame) const;
  absl::StatusOr<std::shared_ptr<FrameLabeller>> Of(size_t shot) const;
  // Leaves the shots before.
  absl::StatusOr<std::shared_ptr<FrameLabeller>> Enter(size_t shot);

  const FrameLabellerOptions options_;
  size_t current_ = 0;
  mutable std::mutex mutex_;  // guards labellers_
  mutable std::vector<std::shared_ptr<FrameLabeller>> labellers_;
};

}  // namespace egosieve::vision
