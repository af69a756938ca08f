#include "tools/render/overlay_source.h"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/refine/full_maps.h"
#include "tools/run_folder/doubtful_frames.h"
#include "tools/run_folder/map_image.h"
#include "tools/run_folder/segmented_pictures.h"

namespace egosieve::tools {

absl::StatusOr<OverlaySource> OverlaySource::Open(const RunFolder& folder,
                                                  const std::string& input) {
  OverlaySource source(folder);
  EGOSIEVE_ASSIGN_OR_RETURN(source.description_, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(source.ignored_, folder.ReadIgnoredAreas());
  EGOSIEVE_ASSIGN_OR_RETURN(source.frames_, OpenPictures(source.description_, input));
  return source;
}

absl::StatusOr<cv::Mat3b> OverlaySource::Draw(const FrameLine& line,
                                              const OverlayOptions& options) {
  EGOSIEVE_ASSIGN_OR_RETURN(const vision::Frame frame, ReadPicture(line, *frames_));
  OverlayOptions with_ignored = options;
  with_ignored.ignored = ignored_.In(line);
  const std::string caption = absl::StrFormat("frame %d  %.2f s%s", line.index, line.time_seconds,
                                              DoubtOf(line).empty() ? "" : "  unreliable");
  const std::string ids_path = folder_.FrameFile("ids", line.index, ".png");
  if (shows_movers_ && std::filesystem::exists(ids_path)) {
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat ids, ReadImage(ids_path, cv::IMREAD_UNCHANGED));
    if (ids.type() != CV_16UC1 || ids.size() != frame.image.size()) {
      return absl::DataLossError(absl::StrCat(ids_path, " is damaged; run egosieve refine again"));
    }
    return DrawMovers(frame.image, ids, caption, with_ignored);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const FrameMaps maps, folder_.ReadGridMaps(line, description_, false));
  EGOSIEVE_ASSIGN_OR_RETURN(cv::Mat1f probability,
                            InterpolateMap(GridOf(line, description_), maps.probability));
  probability.setTo(0.0F, with_ignored.ignored);
  return DrawOverlay(frame.image, probability, caption, with_ignored);
}

}  // namespace egosieve::tools
