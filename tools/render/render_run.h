// Overlays of a run, from its maps and its input's frames.
#ifndef EGOSIEVE_TOOLS_RENDER_RENDER_RUN_H_
#define EGOSIEVE_TOOLS_RENDER_RENDER_RUN_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "kernels/runtime/context.h"
#include "tools/render/overlay.h"
#include "tools/run_folder/run_folder.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {

// Draws the overlays of frames, in the order in which they are asked for; going on is cheap, going
// back starts a video anew.
class OverlaySource {
 public:
  // `input` replaces the path in run.json where that is not empty. NotFound and the like, where the
  // input cannot be opened any more, say what to do.
  static absl::StatusOr<OverlaySource> Open(std::shared_ptr<kernels::Context> context,
                                            const RunFolder& folder, const std::string& input);

  // Whether movers are drawn where reconstruct has numbered them, as at first, or the map always.
  void ShowMovers(bool shows_movers) { shows_movers_ = shows_movers; }

  // The overlay of a frame that did not fail. DataLoss where the input's frame is gone, damaged or
  // of another size.
  absl::StatusOr<cv::Mat3b> Draw(const FrameLine& line, const OverlayOptions& options);

 private:
  OverlaySource(std::shared_ptr<kernels::Context> context, const RunFolder& folder)
      : context_(std::move(context)), folder_(folder) {}

  std::shared_ptr<kernels::Context> context_;
  RunFolder folder_;
  RunDescription description_;
  cv::Mat1b ignored_;  // RunFolder::ReadIgnoredArea
  std::unique_ptr<vision::FrameSource> frames_;
  bool shows_movers_ = true;
};

// Frames per second of the run, by the median of their distances in time; 10 where there is
// no clock. Between 1 and 60.
double FrameRate(const std::vector<FrameLine>& lines);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RENDER_RENDER_RUN_H_
