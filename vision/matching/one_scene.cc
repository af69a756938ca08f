#include "vision/matching/one_scene.h"

#include "vision/matching/scene_agreement.h"

namespace egosieve::vision {

bool ShowOneScene(const FlowPair& flow, const cv::Mat& first, const cv::Mat& second) {
  const TrackedGrid grid = TrackGrid(flow, first, second, /*anchor_second=*/true, {});
  SceneAgreement scene(second.size());
  for (size_t i = 0; i < grid.textured.size(); ++i) {
    scene.AddFlow(grid.textured[i], grid.agrees[i] != 0);
  }
  return scene.IsOneScene();
}

}  // namespace egosieve::vision
