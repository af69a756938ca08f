#include "vision/labelling/focal_learner.h"

#include <algorithm>
#include <utility>

#include "vision/labelling/reduced_labels.h"
#include "vision/trajectory/bundle_adjustment.h"

namespace egosieve::vision {
namespace {

constexpr size_t kFewestDirections = 8, kMostDirections = 64;  // powers of two
constexpr double kLeastApart = 0.1, kShareApart = 1.0 / 16.0;  // seconds; of the time passed

bool IsPowerOfTwo(size_t n) { return (n & (n - 1)) == 0; }

}  // namespace

cv::Mat FocalLearner::Picture(const Frame& frame, const cv::Mat& grey) const {
  if (grey.size() == ReducedSize(frame.image.size(), kLongestDriveSide)) return grey;
  return EqualizedGrey(ReducePicture(frame.image, kLongestDriveSide), equalization_);
}

bool FocalLearner::Add(const Frame& frame, const cv::Mat& grey) {
  if (frame.image.size() != state_.size) {
    FocalLearnerState anew;
    anew.learnt = state_.learnt;
    anew.size = frame.image.size();
    state_ = std::move(anew);
    EndScene();
  }
  state_.last_index = frame.index;
  if (state_.has_ended) return false;
  if (lacks_picture_) EndScene();
  const int64_t number = state_.pictures++;
  if (window_.pictures() == 0) {
    if (number < state_.next_start) return false;
    state_.window_start = number;
  }
  window_.Add(Picture(frame, grey), frame.time_seconds);
  if (window_.IsLost()) EndScene();
  return window_.IsLongEnough() && EndWindow();
}

bool FocalLearner::AddDirection(const Eigen::Vector3d& direction, double seconds) {
  std::vector<Eigen::Vector3d>& directions = state_.directions;
  if (directions.empty()) state_.first_seconds = state_.next_seconds = seconds;
  if (seconds < state_.next_seconds || directions.size() >= kMostDirections) return false;
  state_.next_seconds =
      seconds + std::max(kLeastApart, (seconds - state_.first_seconds) * kShareApart);
  directions.push_back(direction);
  if (directions.size() < kFewestDirections || !IsPowerOfTwo(directions.size())) return false;
  TravelPrior travel = FitTravelPrior(directions);
  if (travel.IsOfVehicle()) {
    travel.share = 1.0 - TravelPrior::kVehicleTravelsElsewhere;
  } else {
    travel = TravelPrior();
  }
  state_.learnt.travel = travel;
  return true;
}

void FocalLearner::EndScene() {
  window_ = WindowTracks();
  lacks_picture_ = false;
}

bool FocalLearner::EndWindow() {
  const bool has_moved = window_.HasMoved();
  state_.next_start = has_moved ? 2 * state_.window_start : state_.pictures + window_.pictures();
  if (has_moved) {
    state_.windows.push_back(window_.Kept(ReduceMask(ignored_, kLongestDriveSide)));
  }
  EndScene();
  return has_moved && IsPowerOfTwo(state_.windows.size()) && Adjust();
}

bool FocalLearner::Adjust() {
  std::vector<TrackWindow> windows;
  const cv::Size reduced = ReducedSize(state_.size, kLongestDriveSide);
  for (const KeptTracks& kept : state_.windows) {
    windows.push_back(EnlargeTracks(kept, reduced, state_.size));
  }
  const AdjustedLens lens = AdjustLens(windows, state_.size, Distortion::kNone);
  if (state_.windows.size() >= size_t{kMostWindows}) {
    state_.windows.clear();
    state_.has_ended = lens.windows > 0;
  }
  if (lens.windows == 0) return false;
  state_.learnt.focal_ratio = lens.focal_ratio;
  state_.learnt.log_focal_deviation = lens.log_focal_deviation;
  return true;
}

FocalLearnerState FocalLearner::state() const {
  FocalLearnerState state = state_;
  state.start_seconds = window_.start_seconds();
  state.under_way = window_.Tracks();
  return state;
}

void FocalLearner::Restore(FocalLearnerState state) {
  window_ = WindowTracks::Of(state.under_way, state.start_seconds);
  lacks_picture_ = window_.pictures() > 0;
  state.under_way = KeptTracks();
  state_ = std::move(state);
}

void FocalLearner::Prime(const Frame& frame, const cv::Mat& grey) {
  if (frame.index > state_.last_index) EndScene();
  if (!lacks_picture_ || frame.index != state_.last_index || frame.image.size() != state_.size) {
    return;
  }
  window_.SetLastPicture(Picture(frame, grey));
  lacks_picture_ = false;
}

}  // namespace egosieve::vision
