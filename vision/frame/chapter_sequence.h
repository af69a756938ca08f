// One drive from several videos, in the order given. Each video is opened once to check that it can
// be read; the others are left out, and the warning at the end names them. A chapter's first frame
// follows the last frame of the previous chapter by that chapter's frame interval, since files do
// not state how long the camera paused. The frames before an index are counted, not estimated.
#ifndef EGOSIEVE_VISION_FRAME_CHAPTER_SEQUENCE_H_
#define EGOSIEVE_VISION_FRAME_CHAPTER_SEQUENCE_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {

absl::StatusOr<std::unique_ptr<FrameSource>> OpenChapters(std::vector<std::string> paths,
                                                          const std::string& description,
                                                          const FrameSourceOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_CHAPTER_SEQUENCE_H_
