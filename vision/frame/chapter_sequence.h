// One drive from several videos, in the order given. Each is opened once to see that it can be
// read; a chapter's first frame follows the last one of the chapter before by that one's interval,
// for files do not say how long the camera paused. Frames before an index are counted, not guessed.
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
