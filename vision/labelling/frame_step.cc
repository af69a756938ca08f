#include "vision/labelling/frame_step.h"

#include <algorithm>
#include <cmath>

namespace egosieve::vision {

CameraStep StepOf(const FrameViews& views, const std::vector<TrackedPoint>& points,
                  const Pinhole& camera) {
  if (views.world == nullptr) return {};
  if (views.gap > 1 && views.behind->frame == nullptr) return {};
  const Eigen::Matrix3d rotation = views.gap > 1
                                       ? Eigen::Matrix3d(views.behind->motion.rotation.transpose())
                                       : views.world->rotation;
  const Outlook& outlook = *views.outlook;
  const bool is_far = outlook.far.frame != nullptr;
  const View& ahead = outlook.longest();
  StepViews step;
  step.behind = views.world;
  step.pictures_behind = views.gap;
  if (ahead.frame != nullptr) {
    step.ahead = &ahead.motion;
    const double steps = static_cast<double>(ahead.frame->frame.index - views.index) /
                         static_cast<double>(views.index - views.index_before);
    step.pictures_ahead = std::max(1, static_cast<int>(std::lround(steps)));
  }
  for (const TrackedPoint& point : points) {
    const cv::Point2f there = is_far ? point.far_ahead : point.near_ahead;
    const cv::Point2f now = point.evidence.now, before = point.evidence.before;
    if (!point.is_textured || !point.evidence.HasBefore() || !std::isfinite(there.x)) continue;
    step.places.push_back({{before.x, before.y, now.x, now.y}, {now.x, now.y, there.x, there.y}});
  }
  return MeasureStep(rotation, step, camera);
}

}  // namespace egosieve::vision
