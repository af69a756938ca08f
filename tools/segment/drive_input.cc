#include "tools/segment/drive_input.h"

#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>
#include <variant>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"
#include "vision/frame/file_list.h"
#include "vision/frame/video_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

std::string KindOf(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return "folder";
  if (!fs::exists(path, error)) return "glob";
  return vision::HasListExtension(path) ? "list" : "video";
}

void TakeFirst(const cv::Mat& image, DriveInput& input) {
  input.width_pixels = image.cols;
  input.height_pixels = image.rows;
  input.description.fingerprint =
      absl::StrCat(Fingerprint(image), "-", input.frames->expected_frame_count());
}

}  // namespace

// The Fowler-Noll-Vo hash, 64 bits.
std::string Fingerprint(const cv::Mat& image) {
  uint64_t hash = 0xcbf29ce484222325;
  for (int y = 0; y < image.rows; ++y) {
    const uint8_t* row = image.ptr<uint8_t>(y);
    for (size_t x = 0; x < image.cols * image.elemSize(); ++x) {
      hash = (hash ^ row[x]) * 0x100000001b3;
    }
  }
  return absl::StrFormat("%016x", hash);
}

absl::StatusOr<DriveInput> OpenDriveInput(const std::string& path, int64_t from,
                                          const vision::FrameSourceOptions& options) {
  DriveInput input;
  absl::StatusOr<std::unique_ptr<vision::FrameSource>> frames =
      vision::OpenFrameSource(path, options);
  if (!frames.ok()) {
    return AsInputError(frames.status());
  }
  input.frames = *std::move(frames);
  EGOSIEVE_RETURN_IF_ERROR(AsInputError(input.frames->SeekTo(from)));
  std::string damage;
  while (true) {
    const absl::StatusOr<vision::FrameRead> read = input.frames->Next();
    if (!read.ok()) {
      return AsInputError(read.status());
    }
    if (const auto* end = std::get_if<vision::EndOfFrames>(&*read)) {
      return absl::DataLossError(
          damage.empty() ? absl::StrCat(path, " has ", end->frame_count,
                                        " frames; choose --from=", from, " below that")
                         : absl::StrCat("no frame of ", path, " can be read: ", damage));
    }
    if (const auto* damaged = std::get_if<vision::DamagedFrame>(&*read)) {
      damage = damaged->reason;
      continue;
    }
    TakeFirst(std::get<vision::Frame>(*read).image, input);
    input.description.path = fs::absolute(path).lexically_normal().string();
    input.description.kind = KindOf(path);
    input.description.remarks = input.frames->remarks();
    return input;
  }
}

absl::StatusOr<DriveInput> OpenLiveInput(const std::string& address) {
  DriveInput input;
  absl::StatusOr<std::unique_ptr<vision::FrameSource>> frames = vision::OpenLiveStream(address);
  if (!frames.ok()) return AsInputError(frames.status());
  input.frames = *std::move(frames);
  const absl::StatusOr<vision::FrameRead> first = input.frames->Next();
  if (!first.ok()) return AsInputError(first.status());
  TakeFirst(std::get<vision::Frame>(*first).image, input);
  input.is_live = true;
  input.description.path = input.frames->description();
  input.description.kind = "stream";
  EGOSIEVE_RETURN_IF_ERROR(AsInputError(input.frames->SeekTo(0)));
  return input;
}

absl::StatusOr<double> SecondsPerFrame(vision::FrameSource& frames, int64_t from) {
  const int64_t next = frames.next_index();
  EGOSIEVE_RETURN_IF_ERROR(frames.SeekTo(from));
  std::optional<vision::Frame> first;
  double seconds = 0.0;
  while (true) {
    EGOSIEVE_ASSIGN_OR_RETURN(vision::FrameRead read, frames.Next());
    if (std::holds_alternative<vision::EndOfFrames>(read)) break;
    auto* frame = std::get_if<vision::Frame>(&read);
    if (frame == nullptr) continue;
    if (first) {
      seconds = (frame->time_seconds - first->time_seconds) /
                static_cast<double>(frame->index - first->index);
      break;
    }
    first = std::move(*frame);
  }
  EGOSIEVE_RETURN_IF_ERROR(frames.SeekTo(next));
  return seconds;
}

}  // namespace egosieve::tools
