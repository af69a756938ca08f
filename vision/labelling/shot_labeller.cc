#include "vision/labelling/shot_labeller.h"

#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "vision/labelling/track_labeller.h"

namespace egosieve::vision {

absl::StatusOr<std::unique_ptr<FrameLabeller>> ShotLabeller::Create(
    const FrameLabellerOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  return std::unique_ptr<FrameLabeller>(new ShotLabeller(options));
}

size_t ShotLabeller::ShotOf(int64_t frame) const {
  size_t shot = options_.later_shots.size();
  while (shot > 0 && OptionsOf(shot).first_frame > frame) --shot;
  return shot;
}

absl::StatusOr<std::shared_ptr<FrameLabeller>> ShotLabeller::Of(size_t shot) const {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<FrameLabeller>& labeller = labellers_[shot];
  if (labeller == nullptr) {
    FrameLabellerOptions options = OptionsOf(shot);
    options.later_shots.clear();
    EGOSIEVE_ASSIGN_OR_RETURN(labeller, TrackLabeller::Create(options));
  }
  return labeller;
}

absl::StatusOr<std::shared_ptr<FrameLabeller>> ShotLabeller::Enter(size_t shot) {
  if (shot > current_) {
    const std::lock_guard lock(mutex_);
    for (size_t former = 0; former < shot; ++former) labellers_[former].reset();
    current_ = shot;
  }
  return Of(shot);
}

absl::StatusOr<std::shared_ptr<const ExtractedFrame>> ShotLabeller::Extract(
    const Frame& frame) const {
  EGOSIEVE_ASSIGN_OR_RETURN(const auto labeller, Of(ShotOf(frame.index)));
  return labeller->Extract(frame);
}

absl::Status ShotLabeller::Prepare(const ExtractedFrame& first,
                                   const ExtractedFrame& second) const {
  const size_t shot = ShotOf(second.frame.index);
  if (ShotOf(first.frame.index) != shot) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const auto labeller, Of(shot));
  return labeller->Prepare(first, second);
}

absl::StatusOr<LabelledFrame> ShotLabeller::Label(
    std::shared_ptr<const ExtractedFrame> frame,
    const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead) {
  const size_t shot = ShotOf(frame->frame.index);
  EGOSIEVE_ASSIGN_OR_RETURN(const auto labeller, Enter(shot));
  std::vector<std::shared_ptr<const ExtractedFrame>> of_shot;
  for (const auto& picture : ahead) {
    if (ShotOf(picture->frame.index) == shot) of_shot.push_back(picture);
  }
  return labeller->Label(std::move(frame), of_shot);
}

absl::Status ShotLabeller::Prime(const Frame& frame) {
  const size_t shot = ShotOf(frame.index);
  if (shot < current_) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const auto labeller, Enter(shot));
  return labeller->Prime(frame);
}

std::string ShotLabeller::state() const {
  const auto labeller = Of(current_);
  const uint64_t shot = current_;
  std::string bytes(sizeof shot, '\0');
  std::memcpy(bytes.data(), &shot, sizeof shot);
  if (labeller.ok()) absl::StrAppend(&bytes, (*labeller)->state());
  return bytes;
}

absl::Status ShotLabeller::Restore(absl::string_view state) {
  uint64_t shot = 0;
  EGOSIEVE_REQUIRE(InvalidArgument, state.size() >= sizeof shot, "%s",
                   "the state of the labels is cut short");
  std::memcpy(&shot, state.data(), sizeof shot);
  EGOSIEVE_REQUIRE(InvalidArgument, shot < labellers_.size(),
                   "the state is of shot %d; there are %d", shot, labellers_.size());
  EGOSIEVE_ASSIGN_OR_RETURN(const auto labeller, Of(shot));
  EGOSIEVE_RETURN_IF_ERROR(labeller->Restore(state.substr(sizeof shot)));
  current_ = shot;
  return absl::OkStatus();
}

}  // namespace egosieve::vision
