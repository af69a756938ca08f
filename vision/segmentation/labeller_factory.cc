#include "vision/segmentation/labeller_factory.h"

#include "vision/labelling/track_labeller.h"
#include "vision/paper/paper_labeller.h"

namespace egosieve::vision {

absl::StatusOr<std::unique_ptr<FrameLabeller>> MakeFrameLabeller(
    const FrameLabellerOptions& options) {
  return options.is_paper ? PaperLabeller::Create(options) : TrackLabeller::Create(options);
}

}  // namespace egosieve::vision
