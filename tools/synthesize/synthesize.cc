#include "tools/synthesize/synthesize.h"

#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/synthesize/scene_file.h"
#include "vision/frame/written_video.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImageFolders[] = {"frames", "masks", "ids"};
constexpr const char* kSceneFile = "scene.json";
constexpr const char* kVideoFile = "video.mp4";

bool IsDriveEntry(const fs::path& entry) {
  const std::string name = entry.filename().string();
  for (const char* folder : kImageFolders) {
    if (name == folder) return true;
  }
  return name == kSceneFile || name == kVideoFile;
}

// NNNNNN.png
bool IsFrameFile(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.size() == 10 && name.find_first_not_of("0123456789") == 6 &&
         file.extension() == ".png";
}

absl::Status RemoveDrive(const std::string& folder) {
  std::vector<fs::path> doomed;
  std::error_code error;
  for (const char* name : {kSceneFile, kVideoFile}) {
    if (fs::exists(fs::path(folder) / name, error)) doomed.push_back(fs::path(folder) / name);
  }
  for (const char* images : kImageFolders) {
    const fs::path path = fs::path(folder) / images;
    if (!fs::exists(path, error)) continue;
    for (const auto& entry : fs::directory_iterator(path, error)) {
      if (!IsFrameFile(entry.path())) {
        return absl::AlreadyExistsError(absl::StrCat(
            entry.path().string(), " is no part of a synthetic drive; name another folder"));
      }
      doomed.push_back(entry.path());
    }
  }
  for (const fs::path& path : doomed) {
    if (!fs::remove(path, error) || error) {
      return absl::UnavailableError(
          absl::StrCat(path.string(), " cannot be removed: ", error.message()));
    }
  }
  return absl::OkStatus();
}

absl::Status PrepareFolder(const SynthesizeOptions& options) {
  const std::string& folder = options.output_folder;
  if (folder.empty()) return absl::InvalidArgumentError("no output folder; name one");
  std::error_code error;
  if (fs::exists(folder, error)) {
    if (!fs::is_directory(folder, error)) {
      return absl::AlreadyExistsError(absl::StrCat(folder, " is a file; name a folder"));
    }
    fs::directory_iterator entries(folder, error);
    if (error) {
      return absl::PermissionDeniedError(
          absl::StrCat(folder, " cannot be read: ", error.message(), "; name another folder"));
    }
    bool empty = true;
    for (const auto& entry : entries) {
      empty = false;
      if (!IsDriveEntry(entry.path())) {
        return absl::AlreadyExistsError(
            absl::StrCat(folder, " holds ", entry.path().filename().string(),
                         ", which is no part of a synthetic drive; name another folder"));
      }
    }
    if (!empty && !options.overwrite) {
      return absl::AlreadyExistsError(
          absl::StrCat(folder, " holds a drive already; name another folder or allow overwriting"));
    }
    if (!empty) EGOSIEVE_RETURN_IF_ERROR(RemoveDrive(folder));
  }
  for (const char* images : kImageFolders) {
    if (options.video && images == std::string("frames")) continue;
    EGOSIEVE_RETURN_IF_ERROR(CreateFolder((fs::path(folder) / images).string()));
  }
  return absl::OkStatus();
}

absl::Status WritePng(const std::string& path, const cv::Mat& image) {
  std::vector<uchar> bytes;
  if (!cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1})) {
    return absl::InternalError(absl::StrCat(path, " could not be encoded"));
  }
  return WriteFileAtomically(
      path, absl::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

class DriveWriter {
 public:
  explicit DriveWriter(const SynthesizeOptions& options) : options_(options) {}

  absl::Status Write(const vision::SyntheticFrame& frame) {
    EGOSIEVE_RETURN_IF_ERROR(WritePng(File("masks", frame.index), frame.mask));
    EGOSIEVE_RETURN_IF_ERROR(WritePng(File("ids", frame.index), frame.ids));
    return options_.video ? WriteToVideo(frame.image)
                          : WritePng(File("frames", frame.index), frame.image);
  }

  absl::Status Finish() {
    if (!options_.video) return absl::OkStatus();
    video_.release();
    return vision::CheckWrittenVideo(VideoPath(), options_.rendering.frames);
  }

 private:
  std::string File(const char* folder, int index) const {
    return absl::StrFormat("%s/%s/%06d.png", options_.output_folder, folder, index);
  }

  std::string VideoPath() const { return absl::StrCat(options_.output_folder, "/", kVideoFile); }

  absl::Status WriteToVideo(const cv::Mat& image) {
    const std::string path = VideoPath();
    if (!video_.isOpened() && !video_.open(path, cv::VideoWriter::fourcc('m', 'p', '4', 'v'),
                                           options_.rendering.frames_per_second, image.size())) {
      return absl::UnavailableError(
          absl::StrCat(path, " cannot be written as MPEG-4 video here; write frames instead"));
    }
    video_.write(image);
    return absl::OkStatus();
  }

  const SynthesizeOptions& options_;
  cv::VideoWriter video_;
};

}  // namespace

absl::Status Synthesize(const SynthesizeOptions& options, const AfterFrame& after_frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(
      const vision::Scenario scenario,
      vision::MakeScenario(options.scenario, options.seed, options.rendering));
  EGOSIEVE_RETURN_IF_ERROR(PrepareFolder(options));
  DriveWriter writer(options);
  nlohmann::ordered_json scene = DescribeScenario(scenario, options.video);
  const int frames = options.rendering.frames;
  for (int index = 0; index < frames; ++index) {
    EGOSIEVE_ASSIGN_OR_RETURN(const vision::SyntheticFrame frame, scenario.Render(index));
    EGOSIEVE_RETURN_IF_ERROR(writer.Write(frame));
    scene["frames"].push_back(DescribeFrame(frame));
    if (after_frame && !after_frame(index + 1, frames)) {
      return absl::CancelledError(absl::StrFormat("interrupted after %d of %d frames; %s has no %s",
                                                  index + 1, frames, options.output_folder,
                                                  kSceneFile));
    }
  }
  EGOSIEVE_RETURN_IF_ERROR(writer.Finish());
  return WriteFileAtomically(absl::StrCat(options.output_folder, "/", kSceneFile),
                             SceneText(scene));
}

}  // namespace egosieve::tools
