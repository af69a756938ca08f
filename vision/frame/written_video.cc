#include "vision/frame/written_video.h"

#include <fcntl.h>
#include <unistd.h>

#include <memory>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "vision/frame/frame_source.h"
#include "vision/frame/video_file.h"

namespace egosieve::vision {
namespace {

bool Sync(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool synced = fsync(descriptor) == 0;
  return close(descriptor) == 0 && synced;
}

}  // namespace

absl::Status CheckWrittenVideo(const std::string& path, int64_t frames) {
  if (Sync(path)) {
    const absl::StatusOr<std::unique_ptr<FrameSource>> video = OpenVideoFile(path, {});
    if (video.ok() && (*video)->expected_frame_count() == frames) return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(absl::StrCat(
      "cannot write the video ", path, " with all of its ", frames, " frames; free some space"));
}

}  // namespace egosieve::vision
