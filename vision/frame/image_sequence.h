// Frames from picture files, in the order given. times_seconds: one per file; empty: times of the
// nominal rate. remarks: those on the files (FrameSource::remarks). InvalidArgument if none of the
// files can be read.
#ifndef EGOSIEVE_VISION_FRAME_IMAGE_SEQUENCE_H_
#define EGOSIEVE_VISION_FRAME_IMAGE_SEQUENCE_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {

absl::StatusOr<std::unique_ptr<FrameSource>> OpenImageSequence(std::vector<std::string> paths,
                                                               std::vector<double> times_seconds,
                                                               std::vector<std::string> remarks,
                                                               const std::string& description,
                                                               const FrameSourceOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_IMAGE_SEQUENCE_H_
