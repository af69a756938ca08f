// Prior of a camera's focal length f over the image's longer side L, in (BA4) of
// bundle_adjustment.h: Student's t of (log(f / L) - log 0.7) / 0.4 with 3 degrees of freedom.
#ifndef EGOSIEVE_VISION_TRAJECTORY_FOCAL_LENGTH_PRIOR_H_
#define EGOSIEVE_VISION_TRAJECTORY_FOCAL_LENGTH_PRIOR_H_

namespace egosieve::vision {

// The prior's middle, f / L, and the scale of its logarithm.
inline constexpr double kMiddleFocalRatio = 0.7, kLogFocalScale = 0.4;

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_FOCAL_LENGTH_PRIOR_H_
