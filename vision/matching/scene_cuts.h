// Where a video goes over to another scene.
//
// A cut lies before frame k where (k - 1, k) are not one scene (scene_agreement.h, by the flow of
// pictures of at most 320 pixels), and both (k - 2, k - 1) and (k, k + 1) are: what fails for
// several pairs in a row is a blur, a flash or a covered lens. Cost: a flow for each pair.
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
  std::vector<int64_t> cuts;  // the frames that begin another scene, ascending, above 0
};

// Reads the source to its end; frames that cannot be read are passed over. Cancelled where
// `goes_on` says no, asked before each frame.
absl::StatusOr<SceneCuts> FindSceneCuts(FrameSource& source,
                                        const std::function<bool()>& goes_on = nullptr);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MATCHING_SCENE_CUTS_H_
