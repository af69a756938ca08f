#include "vision/labelling/outlook.h"

#include <Eigen/Geometry>
#include <cmath>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "vision/features/flow_grid.h"
#include "vision/frame/repeated_picture.h"
#include "vision/geometry/motion_model.h"
#include "vision/labelling/label_outcome.h"

namespace egosieve::vision {
namespace {

constexpr double kLeastStaticShare = 0.3;
// Below this motion of the image by rotation, the camera stands.
constexpr double kStillPixels = 0.25;

// The camera is static if there is no parallax and its rotation hardly moves the image.
MotionModelKind KindOf(const TwoViewMotion& motion, const Pinhole& camera) {
  if (motion.HasParallax()) return MotionModelKind::kFundamental;
  const double angle = Eigen::AngleAxisd(motion.rotation).angle();
  return angle * camera.focal_pixels < kStillPixels ? MotionModelKind::kStatic
                                                    : MotionModelKind::kHomography;
}

}  // namespace

bool IsTrusted(const TwoViewMotion& motion) {
  return motion.found && motion.static_share >= kLeastStaticShare;
}

absl::StatusOr<Outlook> LookAhead(const ExtractedFrame& frame,
                                  const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead,
                                  const Pinhole& camera, absl::Span<const float> moved,
                                  PairMotions& motions) {
  PairMotions::Pictures pictures = {&frame};
  for (const auto& picture : ahead) {
    if (picture->frame.image.size() != frame.frame.image.size()) break;
    if (!SamePixels(picture->frame.image, pictures.back()->frame.image)) {
      pictures.push_back(picture.get());
    }
  }
  Outlook outlook;
  if (pictures.size() < 2) return outlook;
  EGOSIEVE_ASSIGN_OR_RETURN(outlook.links, motions.Follow(pictures));
  if (outlook.links.followed_share < kFlowSuffices) return outlook;
  const auto view = [&](const ExtractedFrame& picture, const std::vector<cv::Point2f>& places,
                        cv::Point2f TrackedPoint::*place) {
    View view;
    view.place = place;
    view.motion = motions.Along(frame, picture, outlook.links, places, camera, moved);
    if (IsTrusted(view.motion)) view.frame = &picture;
    return view;
  };
  const GridLinks& links = outlook.links;
  outlook.far = view(*pictures[links.last], links.far, &TrackedPoint::far_ahead);
  if (links.last > 1) outlook.near = view(*pictures[1], links.near, &TrackedPoint::near_ahead);
  return outlook;
}

bool RecordMotion(const TwoViewMotion& motion, const Pinhole& camera, int64_t pair_count,
                  LabelledFrame& result) {
  if (!motion.found) {
    SetOutcome(LabelOutcome::kUntrustedMotion, "too few places to tell the camera's motion from",
               result);
    return false;
  }
  result.parallax_pixels = motion.parallax_pixels;
  result.inlier_count = std::llround(motion.static_share * static_cast<double>(pair_count));
  result.motion_model = KindOf(motion, camera);
  if (IsTrusted(motion)) return true;
  SetOutcome(LabelOutcome::kUntrustedMotion,
             absl::StrFormat("the camera's motion explains %.0f %% of the places",
                             100.0 * motion.static_share),
             result);
  return false;
}

}  // namespace egosieve::vision
