#include "tools/synthesize/synthesize.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <regex>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/atomic_file.h"
#include "vision/frame/video_file.h"
#include "vision/synthetic/street.h"

namespace egosieve::tools {
namespace {

// scene.json: the description of a synthetic drive (synthesize.h explains the fields).

using nlohmann::ordered_json;

// Six decimals: micrometres, microdegrees.
double Rounded(double value) { return std::round(value * 1e6) / 1e6; }

ordered_json Vector(const Eigen::Vector3d& v) {
  return {Rounded(v.x()), Rounded(v.y()), Rounded(v.z())};
}

ordered_json DescribeObject(const vision::ObjectState& object) {
  return {
      {"id", object.id},
      {"class", vision::FactsOf(object.object_class).name},
      {"moving", object.moving},
      {"relation", vision::RelationName(object.relation)},
      {"heading_degrees", Rounded(std::remainder(object.heading_radians, 2 * M_PI) * 180 / M_PI)},
      {"position", Vector(object.position)},
      {"velocity", Vector(object.velocity)},
      {"relative_velocity", Vector(object.relative_velocity)},
      {"distance_metres", Rounded(object.distance_metres)},
      {"area_pixels", object.area_pixels},
      {"box", {object.box.x, object.box.y, object.box.width, object.box.height}}};
}

// All except the frames, which are to be appended to the array "frames".
ordered_json DescribeScenario(const vision::Scenario& scenario, bool video) {
  const vision::ScenarioOptions& options = scenario.options();
  const vision::Intrinsics& k = scenario.intrinsics();
  return {{"format", 1},
          {"scenario", scenario.name()},
          {"seed", scenario.seed()},
          {"width", options.width_pixels},
          {"height", options.height_pixels},
          {"frames_per_second", options.frames_per_second},
          {"video", video},
          {"intrinsics",
           {{"focal_pixels", k.focal_pixels},
            {"centre_x", k.centre_x},
            {"centre_y", k.centre_y},
            {"radial", k.radial}}},
          {"frames", ordered_json::array()}};
}

ordered_json DescribeFrame(const vision::SyntheticFrame& frame) {
  ordered_json pose = ordered_json::array();
  for (int row = 0; row < 3; ++row) {  // in full precision: geometry is computed from it
    const Eigen::Matrix3d& r = frame.pose.rotation;
    pose.push_back({r(row, 0), r(row, 1), r(row, 2), frame.pose.centre[row]});
  }
  ordered_json objects = ordered_json::array();
  for (const vision::ObjectState& object : frame.objects) objects.push_back(DescribeObject(object));
  return {{"index", frame.index},
          {"seconds", Rounded(frame.seconds)},
          {"world_from_camera", pose},
          {"objects", objects}};
}

// camera.json: the lens, and the rate of the frames.
std::string CameraText(const vision::Scenario& scenario) {
  const vision::ScenarioOptions& options = scenario.options();
  const ordered_json camera = {{"focal_pixels", scenario.intrinsics().focal_pixels},
                               {"k1", scenario.intrinsics().radial},
                               {"width", options.width_pixels},
                               {"height", options.height_pixels},
                               {"frames_per_second", options.frames_per_second}};
  return camera.dump(2) + "\n";
}

// A line of poses.txt: the 12 numbers of [R centre], row by row.
std::string PoseLine(const vision::Pose& pose) {
  std::string line;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      absl::StrAppendFormat(&line, "%s%.17g", line.empty() ? "" : " ",
                            column < 3 ? pose.rotation(row, column) : pose.centre[row]);
    }
  }
  return line + "\n";
}

// The document's text: one line per frame.
std::string SceneText(const ordered_json& scene) {
  ordered_json head = scene;
  head.erase("frames");
  std::string text = head.dump();
  text.pop_back();  // the closing brace
  text += ",\n\"frames\":[";
  const char* separator = "\n";
  for (const ordered_json& frame : scene.at("frames")) {
    text += separator + frame.dump();
    separator = ",\n";
  }
  return text + "\n]}\n";
}

namespace fs = std::filesystem;

constexpr const char* kImageFolders[] = {"frames", "masks", "ids"};
constexpr const char* kSceneFile = "scene.json";
constexpr const char* kVideoFile = "video.mp4";
constexpr const char* kCodedFile = "coded.mp4";        // exists only during writing
constexpr const char* kUnfinishedFile = "unfinished";  // exists until scene.json is written
constexpr int kJpegQuality = 60;

// Whether a synthetic drive has a file or folder of this path.
bool IsDrivePath(const std::string& path) {
  static const auto& own = *new std::regex(
      "(frames|masks|ids)(/[0-9]{6}\\.png)?|(video|coded)\\.mp4|poses\\.txt|camera\\.json|"
      "own_vehicle\\.png|scene\\.json|unfinished");
  return std::regex_match(path, own);
}

// AlreadyExists unless the folder is absent, empty, or a drive that may be removed, which then is.
absl::Status RemoveDrive(const std::string& folder, bool overwrite) {
  std::error_code error;
  if (!fs::exists(folder, error)) return absl::OkStatus();
  if (!fs::is_directory(folder, error)) {
    return absl::AlreadyExistsError(absl::StrCat(folder, " is a file; name a folder"));
  }
  const fs::recursive_directory_iterator entries(folder, error);
  if (error) {
    return absl::PermissionDeniedError(
        absl::StrCat(folder, " cannot be read: ", error.message(), "; name another folder"));
  }
  // The file that marks the folder as a drive is removed last. Other folders may have frames and
  // masks, too.
  std::vector<fs::path> doomed, marks;
  for (const auto& entry : entries) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (!IsDrivePath(name)) {
      return absl::AlreadyExistsError(absl::StrCat(
          folder, " holds ", name, ", which is no part of a synthetic drive; name another folder"));
    }
    if (entry.is_directory(error)) continue;
    (name == kSceneFile || name == kUnfinishedFile ? marks : doomed).push_back(entry.path());
  }
  if (fs::is_empty(folder, error)) return absl::OkStatus();
  if (!overwrite) {
    return absl::AlreadyExistsError(
        absl::StrCat(folder, " holds a drive already; name another folder or allow overwriting"));
  }
  if (marks.empty()) {
    return absl::AlreadyExistsError(absl::StrCat(
        folder, " holds no ", kSceneFile, " and so no synthetic drive; name another folder"));
  }
  doomed.insert(doomed.end(), marks.begin(), marks.end());
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
  EGOSIEVE_RETURN_IF_ERROR(RemoveDrive(folder, options.overwrite));
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder));
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically((fs::path(folder) / kUnfinishedFile).string(), ""));
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
      path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

absl::StatusOr<cv::Mat> ThroughJpeg(const cv::Mat& image) {
  std::vector<uchar> bytes;
  if (!cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality})) {
    return absl::InternalError("a frame could not be encoded as JPEG");
  }
  return cv::imdecode(bytes, cv::IMREAD_COLOR);
}

class DriveWriter {
 public:
  explicit DriveWriter(const SynthesizeOptions& options)
      : options_(options), through_h264_(options.compression == Compression::kH264) {}

  absl::Status Write(const vision::SyntheticFrame& frame) {
    EGOSIEVE_RETURN_IF_ERROR(WritePng(File("masks", frame.index), frame.mask));
    EGOSIEVE_RETURN_IF_ERROR(WritePng(File("ids", frame.index), frame.ids));
    if (frame.index == 0 && !frame.own_vehicle.empty()) {
      EGOSIEVE_RETURN_IF_ERROR(WritePng(Path("own_vehicle.png"), frame.own_vehicle));
    }
    poses_ += PoseLine(frame.pose);
    cv::Mat image = frame.image;
    if (options_.compression == Compression::kJpeg) {
      EGOSIEVE_ASSIGN_OR_RETURN(image, ThroughJpeg(image));
    }
    return options_.video || through_h264_ ? WriteToVideo(image)
                                           : WritePng(File("frames", frame.index), image);
  }

  absl::Status Finish() {
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(Path("poses.txt"), poses_));
    if (!options_.video && !through_h264_) return absl::OkStatus();
    video_.release();
    EGOSIEVE_RETURN_IF_ERROR(vision::CheckWrittenVideo(VideoPath(), options_.rendering.frames));
    return options_.video ? absl::OkStatus() : DecodeVideo();
  }

 private:
  std::string Path(const char* name) const {
    return absl::StrCat(options_.output_folder, "/", name);
  }
  std::string File(const char* folder, int index) const {
    return absl::StrFormat("%s/%s/%06d.png", options_.output_folder, folder, index);
  }
  std::string VideoPath() const { return Path(options_.video ? kVideoFile : kCodedFile); }

  absl::Status WriteToVideo(const cv::Mat& image) {
    const int codec = through_h264_ ? cv::VideoWriter::fourcc('a', 'v', 'c', '1')
                                    : cv::VideoWriter::fourcc('m', 'p', '4', 'v');
    if (!video_.isOpened() &&
        !video_.open(VideoPath(), codec, options_.rendering.frames_per_second, image.size())) {
      return absl::UnavailableError(absl::StrCat(VideoPath(), " cannot be written as ",
                                                 through_h264_ ? "H.264" : "MPEG-4",
                                                 " video here; write frames instead"));
    }
    video_.write(image);
    return absl::OkStatus();
  }

  // Writes frames/ from the coded video, which is then removed.
  absl::Status DecodeVideo() {
    cv::VideoCapture coded(VideoPath());
    int index = 0;
    for (cv::Mat image; coded.read(image); ++index) {
      EGOSIEVE_RETURN_IF_ERROR(WritePng(File("frames", index), image));
    }
    if (index != options_.rendering.frames) {
      return absl::InternalError(absl::StrFormat("%s gave %d of %d frames back", VideoPath(), index,
                                                 options_.rendering.frames));
    }
    std::error_code error;
    fs::remove(VideoPath(), error);
    return absl::OkStatus();
  }

  const SynthesizeOptions& options_;
  const bool through_h264_;
  cv::VideoWriter video_;
  std::string poses_;
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
      return absl::CancelledError(absl::StrFormat(
          "interrupted after %d of %d frames; %s has no %s, --overwrite begins again", index + 1,
          frames, options.output_folder, kSceneFile));
    }
  }
  EGOSIEVE_RETURN_IF_ERROR(writer.Finish());
  const fs::path folder = options.output_folder;
  EGOSIEVE_RETURN_IF_ERROR(
      WriteFileAtomically((folder / "camera.json").string(), CameraText(scenario)));
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically((folder / kSceneFile).string(), SceneText(scene)));
  std::error_code error;  // if this fails, the extra file does no harm
  fs::remove(folder / kUnfinishedFile, error);
  return absl::OkStatus();
}

}  // namespace egosieve::tools
