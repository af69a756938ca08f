// Finds the cuts of a video: the frames at which another scene begins.
//
// A cut lies before frame k where (k - 1, k) are not one scene (scene_agreement.h, by the flow of
// pictures of at most 320 pixels), and both (k - 2, k - 1) and (k, k + 1) are; a pair beyond the
// ends of the video counts as one scene. Several failing pairs in a row are a blur, a flash or a
// covered lens. Cost: one flow per pair.
#ifndef EGOSIEVE_VISION_MATCHING_SCENE_CUTS_H_
#define EGOSIEVE_VISION_MATCHING_SCENE_CUTS_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {

struct SceneCuts {
  int64_t frames = 0;         // of the source
  std::vector<int64_t> cuts;  // frames at which another scene begins, ascending, above 0
};

// Reads the source to its end and skips frames that cannot be read. Cancelled if `goes_on` returns
// false; it is called before each frame.
absl::StatusOr<SceneCuts> FindSceneCuts(FrameSource& source,
                                        const std::function<bool()>& goes_on = nullptr);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MATCHING_SCENE_CUTS_H_
