// Overlays of a run, from its maps and its input's frames.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "tools/render/overlay.h"
#include "tools/run_folder/run_folder.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {

// Draws the overlays of frames in the requested order. Moving forwards is cheap; moving backwards
// restarts a video.
class OverlaySource {
 public:
  // `input`, if not empty, replaces the path in run.json. Errors such as NotFound, if the input
  // cannot be opened any more, name the remedy.
  static absl::StatusOr<OverlaySource> Open(const RunFolder& folder, const std::string& input);

  // Whether movers are drawn if refine has numbered them, which is the default, or always the
  // map.
  void ShowMovers(bool shows_movers) { shows_movers_ = shows_movers; }

  // The overlay of a frame that did not fail. DataLoss if the input's frame is missing, damaged or
  // of another size.
  absl::StatusOr<cv::Mat3b> Draw(const FrameLine& line, const OverlayOptions& options);

 private:
  explicit OverlaySource(const RunFolder& folder) : folder_(folder) {}

  RunFolder folder_;
  RunDescription description_;
  IgnoredAreas ignored_;
  std::unique_ptr<vision::FrameSource> frames_;
  bool shows_movers_ = true;
};

}  // namespace egosieve::tools
