#include "tools/run_folder/segmented_pictures.h"

#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"

namespace egosieve::tools {

absl::StatusOr<std::unique_ptr<vision::FrameSource>> OpenPictures(const RunDescription& description,
                                                                  const std::string& input) {
  auto source = vision::OpenFrameSource(input.empty() ? description.input.path : input, {});
  if (source.ok()) return source;
  return absl::DataLossError(absl::StrCat(
      source.status().message(), input.empty() ? "; or say where it is now: --input=" : ""));
}

absl::StatusOr<vision::Frame> ReadPicture(const FrameLine& line, vision::FrameSource& source) {
  if (source.next_index() != line.index) {
    EGOSIEVE_RETURN_IF_ERROR(AsInputError(source.SeekTo(line.index)));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(vision::FrameRead read, source.Next());
  auto* frame = std::get_if<vision::Frame>(&read);
  if (frame == nullptr || frame->image.cols != line.width_pixels ||
      frame->image.rows != line.height_pixels) {
    return OtherPicture(line.index, source);
  }
  return std::move(*frame);
}

absl::Status OtherPicture(int64_t index, const vision::FrameSource& source) {
  return absl::DataLossError(
      absl::StrCat("frame ", index, " of ", source.description(),
                   " is not what was segmented; give the same input with --input="));
}

}  // namespace egosieve::tools
