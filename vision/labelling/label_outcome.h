// What every labeller does alike: the frame's grey picture, whether a pair can be labelled, and why
// not.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "vision/frame/repeated_picture.h"
#include "vision/geometry/pinhole.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/matching/scene_agreement.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

// Of a pair of frames.
struct PairCounts {
  explicit PairCounts(cv::Size size = {1, 1}) : scene(size) {}

  int64_t features = 0;  // features, or textured grid points, of the second frame
  int64_t matches = 0;   // of these, the ones found in the other frame
  int64_t labelled = 0;  // places that can be given labels
  SceneAgreement scene;
};

// Sets frame and grey picture: corrected, reduced and equalised. InvalidArgument unless the image is
// CV_8UC3.
absl::Status MakeGrey(const Frame& frame, const FrameLabellerOptions& options,
                      ExtractedFrame& extracted);

// Converts all places from pixels of the grey picture to those of the frame's, and drops labels of
// places that lie outside. Matrices remain those of the corrected pictures.
void ToPixelsOfFrame(const ExtractedFrame& frame, const LensCorrection* lens,
                     LabelledFrame& labels);

// Appends to the pictures with which later pairs begin, oldest first, at most `most` of one size. The
// later steps are between different pictures: a repeat takes the place of the first.
template <typename Extracted>
void Remember(std::shared_ptr<const Extracted> frame, int most,
              std::deque<std::shared_ptr<const Extracted>>& history) {
  const cv::Mat& image = frame->frame.image;
  if (!history.empty() && history.back()->frame.image.size() != image.size()) history.clear();
  if (!history.empty() && SamePixels(history.back()->frame.image, image)) {
    auto repeat = std::make_shared<Extracted>(*frame);
    repeat->frame.time_seconds = history.back()->frame.time_seconds;
    history.back() = std::move(repeat);
    return;
  }
  history.push_back(std::move(frame));
  if (static_cast<int>(history.size()) > most) history.pop_front();
}

// InvalidArgument unless the frame's index is larger than that of `last`; null: no frame before.
absl::Status CheckOrder(const ExtractedFrame* last, const ExtractedFrame& frame);

// Without places.
LabelledFrame BeginLabels(const ExtractedFrame& frame);

// The three below set the outcome if the frame cannot be labelled, and its reason.
void SetNoPair(int frame_gap, LabelledFrame& result);
bool HasOtherSize(const ExtractedFrame& last, const ExtractedFrame& frame, LabelledFrame& result);
bool IsRepeated(const ExtractedFrame& last, const ExtractedFrame& frame, LabelledFrame& result);
// Whether there are enough correspondences of one scene; else sets the outcome.
bool IsEnough(const PairCounts& counts, LabelledFrame& result);

void SetOutcome(LabelOutcome outcome, std::string reason, LabelledFrame& result);

// `doubt` of labelled_frame.h, from the rest of it.
std::string DoubtOf(const LabelledFrame& labels);
// The same while the focal length is assumed: for a turn under which another one would move static
// places at the border of a picture of `size` by more than their noise; else empty. A turn that
// moves the middle by p moves a place at x by p (1 + x^2 / f^2).
std::string DoubtOfTurn(const TwoViewMotion& motion, const Pinhole& camera, cv::Size size);

}  // namespace egosieve::vision
