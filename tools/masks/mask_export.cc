#include "tools/masks/mask_export.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <system_error>
#include <variant>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"
#include "tools/masks/stored_picture.h"
#include "tools/masks/video_frames.h"
#include "tools/refine/refine_run.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/map_image.h"
#include "tools/run_folder/segmented_pictures.h"
#include "tools/run_folder/written_folder.h"
#include "vision/frame/image_decoding.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

// The folders of the pictures; empty for a video.
std::set<std::string> PictureFolders(const DriveInput& input) {
  std::set<std::string> folders;
  std::error_code error;
  if (fs::is_directory(input.description.path, error)) folders.insert(input.description.path);
  for (const std::string& file : input.frames->files()) {
    if (vision::HasImageExtension(file)) folders.insert(fs::path(file).parent_path().string());
  }
  return folders;
}

// Exists in --out from the beginning of an export to its end: its settings, then what it is made
// from. The same command may write there again, and continues it where the folders were empty.
std::string MarkPath(const MaskExportOptions& options) { return options.out + "/.egosieve_masks"; }

std::string Settings(const MaskExportOptions& options, const RunDescription::Input& input) {
  const FrameMaskOptions& mask = options.mask;
  return absl::StrFormat(
      "format=%d threshold=%g dilate=%d shadow=%d own_vehicle=%d invert=%d also=%s video=%s "
      "frames=%s undistort=%s sparse=%s input=%s\n",
      static_cast<int>(options.format), mask.threshold.value_or(-1.0), mask.dilate_pixels,
      mask.shadow_margin_pixels, mask.own_vehicle ? 1 : 0, options.invert ? 1 : 0, options.also,
      options.video, options.frames, options.undistort, options.sparse, input.fingerprint);
}

// What the masks are made from.
absl::StatusOr<std::string> RunText(const RunFolder& run) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, run.ReadDescription());
  const auto refined =
      nlohmann::json::parse(ReadFile(run.File(kRefineState)).value_or(""), nullptr, false);
  return absl::StrCat(description.started_utc, " ", description.finished_utc, " ",
                      refined.is_object() ? refined.value("options", "") : "");
}

bool IsEmpty(const std::string& folder) {
  std::error_code error;
  return folder.empty() || !fs::exists(folder, error) || fs::is_empty(folder, error);
}

// Checks --out, --frames and the run folder against the input.
absl::Status CheckFolders(const DriveInput& input, const std::string& run,
                          const MaskExportOptions& options) {
  const bool may_hold =
      options.overwrite || absl::StartsWith(ReadFile(MarkPath(options)).value_or(""),
                                            Settings(options, input.description));
  const std::set<std::string> folders = PictureFolders(input);
  std::set<std::string> sources = folders;
  sources.insert(run);
  if (!options.undistort.empty()) {
    for (const char* read : {"/images", "/sparse"}) sources.insert(options.undistort + read);
    sources.insert(options.sparse);
  }
  const std::vector<std::string> files = input.frames->files();
  EGOSIEVE_RETURN_IF_ERROR(CheckWrittenFolder("--out", options.out, sources, files, may_hold));
  if (!options.frames.empty()) {
    EGOSIEVE_RETURN_IF_ERROR(
        CheckWrittenFolder("--frames", options.frames, sources, files, may_hold));
  }
  for (const std::string& folder : folders) {
    if (LiesInFolder(run, folder)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the run folder ", run, " lies in what is read, ", folder, "; name another by --run"));
    }
  }
  return absl::OkStatus();
}

// Flags that exclude each other.
absl::Status CheckFlags(const MaskExportOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.mask.Validate());
  if (HasNumbers(options.format) &&
      (options.invert || options.mask.threshold || options.mask.own_vehicle ||
       options.mask.shadow_margin_pixels > 0 || !options.also.empty())) {
    return absl::InvalidArgumentError(
        "davis, coco and mots take the movers that refine has numbered: leave out "
        "--threshold, "
        "--unsure, --own_vehicle, --shadow_margin, --also and --invert, or use --for=plain");
  }
  if (options.undistort.empty() && options.sparse.empty()) return absl::OkStatus();
  if (options.undistort.empty() || options.sparse.empty()) {
    return absl::InvalidArgumentError(
        "--undistort and --sparse belong together: what image_undistorter wrote, and the model "
        "that it read");
  }
  if (options.format == MaskFormat::kNerfstudio || !options.frames.empty()) {
    return absl::InvalidArgumentError(
        options.frames.empty()
            ? "--for=nerfstudio takes the original pictures and undistorts them; leave --undistort "
              "out"
            : "--frames writes original pictures; image_undistorter has written the undistorted "
              "ones");
  }
  return absl::OkStatus();
}

// Resizes without mixing classes or numbers.
template <typename Mask>
void Resize(cv::Size size, Mask& mask) {
  if (mask.empty() || mask.size() == size) return;
  cv::Mat resized;
  cv::resize(mask, resized, size, 0, 0, cv::INTER_NEAREST);
  mask = resized;
}

}  // namespace

std::string MaskExport::SequenceName() const {
  const fs::path path(input_.description.path);
  const std::string name = path.stem().string();
  // Folders of pictures often have such a name; the parent's name then says more.
  const bool is_generic = name == "frames" || name == "images";
  return is_generic && path.has_parent_path() ? path.parent_path().filename().string() : name;
}

absl::StatusOr<MaskExport> MaskExport::Prepare(DriveInput input, const std::string& run,
                                               const MaskExportOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(CheckFlags(options));
  EGOSIEVE_RETURN_IF_ERROR(CheckFolders(input, run, options));
  MaskExport result(std::move(input), options);
  const vision::FrameSource& source = *result.input_.frames;
  result.files_ = source.files();
  if (result.files_.empty() || !vision::HasImageExtension(result.files_.front())) {
    result.files_.clear();
  }
  if (!options.video.empty() && result.files_.empty()) {
    return absl::InvalidArgumentError(
        "--from_video takes the video, and INPUT the pictures that were taken from it");
  }
  std::vector<std::string> images;
  for (int64_t i = 0; i < source.expected_frame_count(); ++i) images.push_back(result.ImageName(i));
  cv::Size size(result.input_.width_pixels, result.input_.height_pixels);
  if (!result.files_.empty()) {
    const absl::StatusOr<StoredPicture> first = ReadStoredPicture(result.files_.front());
    if (first.ok()) size = first->pixels.size();
  }
  EGOSIEVE_ASSIGN_OR_RETURN(result.also_, UserMasks::Open(options.also, images, size));
  result.warnings_.push_back(result.also_.Describe());
  if (!options.undistort.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        result.undistortion_,
        Undistortion::Open(options.undistort, options.sparse, images, size,
                           RowOf(options.format).masked == MaskedPixel::kTransparent));
  }
  const std::string& path = result.input_.description.path;
  if (options.format == MaskFormat::kNerfstudio) {
    EGOSIEVE_ASSIGN_OR_RETURN(result.transforms_,
                              TransformsFile::Read(options.transforms, path, images));
  } else if (!options.transforms.empty()) {
    return absl::InvalidArgumentError("--transforms belongs to --for=nerfstudio; leave it out");
  }
  EGOSIEVE_RETURN_IF_ERROR(result.CheckTargets());
  return result;
}

std::vector<std::string> MaskExport::Targets(int64_t index) const {
  std::vector<std::string> targets;
  const std::string image = ImageName(index);
  const std::string mask = MaskFile(options_.format, image, index, SequenceName());
  if (!mask.empty()) targets.push_back(AbsolutePath(absl::StrCat(options_.out, "/", mask)));
  if (!options_.frames.empty()) {
    targets.push_back(AbsolutePath(absl::StrCat(options_.frames, "/", image)));
  }
  for (const int by : Reductions()) {
    targets.push_back(AbsolutePath(absl::StrCat(options_.out, "/", ReducedMaskFile(image, by))));
  }
  return targets;
}

absl::Status MaskExport::CheckTargets() {
  constexpr size_t kMostBytes = 255;        // of a file's name, on most file systems
  std::map<std::string, int64_t> pictures;  // by target
  for (int64_t i = 0; i < input_.frames->expected_frame_count(); ++i) {
    for (const std::string& target : Targets(i)) {
      if (fs::path(target).filename().string().size() > kMostBytes) {
        return absl::InvalidArgumentError(
            absl::StrCat("the file ", target, " would have a name of more than ", kMostBytes,
                         " bytes; give its picture a shorter name"));
      }
      const auto [place, is_new] = pictures.emplace(target, i);
      if (!is_new) {
        return absl::InvalidArgumentError(absl::StrCat(
            "two files would be ", target, ", of the pictures ",
            input_.frames->image_name(place->second), " and ", input_.frames->image_name(i),
            "; rename one of them, or name different folders for --out and --frames"));
      }
      target_folders_.insert(fs::path(target).parent_path().string());
    }
  }
  for (const std::string& folder : target_folders_) {
    if (LiesInFolder(folder, options_.out)) continue;
    if (!options_.frames.empty() && LiesInFolder(folder, options_.frames)) continue;
    return absl::InvalidArgumentError(absl::StrCat(folder, " leads out of --out=", options_.out,
                                                   " by a link; remove the link, or name "
                                                   "another folder"));
  }
  return absl::OkStatus();
}

absl::Status MaskExport::CheckNumbers(
    const RunFolder& folder, const std::vector<std::pair<int64_t, FrameLine>>& chosen) const {
  const int most = LargestNumber(options_.format);
  if (most >= UINT16_MAX) return absl::OkStatus();
  std::vector<absl::Status> statuses(chosen.size(), absl::OkStatus());
  kernels::ParallelFor(static_cast<int64_t>(chosen.size()), [&](int64_t i) {
    const FrameLine& line = chosen[i].second;
    const absl::StatusOr<FrameMask> mask = ReadFrameMask(folder, line, options_.mask, {});
    statuses[i] = mask.status();
    if (!mask.ok()) return;
    double largest = 0.0;
    cv::minMaxLoc(mask->numbers, nullptr, &largest);
    if (largest <= most) return;
    statuses[i] = absl::OutOfRangeError(absl::StrFormat(
        "frame %d: mover %.0f, where the format has numbers up to %d; use --for=coco, or a shorter "
        "run",
        line.index, largest, most));
  });
  for (const absl::Status& status : statuses) EGOSIEVE_RETURN_IF_ERROR(status);
  return absl::OkStatus();
}

bool MaskExport::IsWritten(int64_t index) const {
  // These are of all frames, or depend on files that may have changed.
  const bool needs_all = !options_.also.empty() || options_.format == MaskFormat::kCoco ||
                         options_.format == MaskFormat::kMots;
  if (needs_all || !continues_) return false;
  const std::vector<std::string> targets = Targets(index);
  return std::all_of(targets.begin(), targets.end(), [](const std::string& target) {
    std::error_code error;
    return fs::is_regular_file(target, error);
  });
}

absl::Status MaskExport::Mark(const RunFolder& folder) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string run, RunText(folder));
  const std::string mark = Settings(options_, input_.description) + run;
  continues_ = ReadFile(MarkPath(options_)).value_or("") == mark;
  const bool is_of_this = continues_ || (IsEmpty(options_.out) && IsEmpty(options_.frames));
  return WriteFileAtomically(MarkPath(options_), is_of_this ? mark : mark + " among others");
}

absl::Status MaskExport::Run(const RunFolder& folder, const std::vector<FrameLine>& lines,
                             const std::function<bool()>& after_frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(options_.mask.ignored, folder.ReadIgnoredAreas());
  EGOSIEVE_ASSIGN_OR_RETURN(const auto chosen, Chosen(lines));
  EGOSIEVE_RETURN_IF_ERROR(CheckNumbers(folder, chosen));
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(options_.out));
  target_folders_.insert(options_.out);
  for (const std::string& target : target_folders_) kernels::RemoveAbandonedTemporaries(target);
  EGOSIEVE_RETURN_IF_ERROR(Mark(folder));
  std::set<std::string> named;
  int64_t without_camera = 0;
  for (const auto& [index, line] : chosen) {
    if (undistortion_ && !undistortion_->Holds(ImageName(index))) {
      ++without_camera;
      continue;
    }
    named.insert(ImageName(index));
    if (IsWritten(index)) {
      ++written_;
    } else {
      EGOSIEVE_RETURN_IF_ERROR(WriteFrame(folder, line, index));
    }
    if (!after_frame()) {
      return absl::CancelledError(absl::StrCat("interrupted; ", images(), " masks are in ",
                                               options_.out, "; the same command goes on"));
    }
  }
  EGOSIEVE_RETURN_IF_ERROR(writer_.Finish());
  if (transforms_) {
    EGOSIEVE_ASSIGN_OR_RETURN(const int left_out, transforms_->Write(options_.out, named));
    if (left_out > 0) {
      warnings_.push_back(absl::StrCat(
          left_out, " frames of transforms.json have no mask and are not in its copy"));
    }
  }
  if (without_camera > 0) {
    warnings_.push_back(absl::StrCat("COLMAP's models have ", named.size(), " of the pictures; ",
                                     without_camera, " others have no mask"));
  }
  const int64_t lacking =
      static_cast<int64_t>(files_.size()) - static_cast<int64_t>(named.size()) - without_camera;
  if (lacking > 0) {
    warnings_.push_back(absl::StrCat(lacking, " of ", files_.size(),
                                     " pictures have no mask: the run does not hold them, or they "
                                     "could not be read"));
  }
  std::error_code error;
  fs::remove(MarkPath(options_), error);
  if (!error) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat("cannot remove ", MarkPath(options_), ": ",
                                             error.message(), "; remove it yourself"));
}

absl::Status MaskExport::FindPictures(vision::FrameSource& video,
                                      const std::function<bool()>& after_frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(frames_, FindInVideo(*input_.frames, video, after_frame));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::pair<int64_t, FrameLine>>> MaskExport::Chosen(
    const std::vector<FrameLine>& lines) const {
  std::vector<std::pair<int64_t, FrameLine>> chosen;
  if (frames_.empty()) {
    for (const FrameLine& line : lines) chosen.emplace_back(line.index, line);
    return chosen;
  }
  for (size_t i = 0; i < frames_.size(); ++i) {
    const auto line = std::lower_bound(
        lines.begin(), lines.end(), frames_[i],
        [](const FrameLine& candidate, int64_t index) { return candidate.index < index; });
    if (line != lines.end() && line->index == frames_[i]) {
      chosen.emplace_back(static_cast<int64_t>(i), *line);
    }
  }
  return chosen;
}

absl::Status MaskExport::WriteFrame(const RunFolder& folder, const FrameLine& line, int64_t index) {
  cv::Mat3b shown;
  if (options_.mask.shadow_margin_pixels > 0) {
    EGOSIEVE_ASSIGN_OR_RETURN(shown, ReadShown(index));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(FrameMask mask, ReadFrameMask(folder, line, options_.mask, shown));
  MaskedFrame frame;
  frame.index = index;
  frame.image = ImageName(index);
  std::string file;
  int orientation = 1;
  if (index < static_cast<int64_t>(files_.size())) {
    file = files_[index];
    EGOSIEVE_ASSIGN_OR_RETURN(const StoredPicture picture, ReadStoredPicture(file));
    frame.picture = picture.pixels;
    orientation = picture.orientation;
  } else if (!options_.frames.empty() || options_.format == MaskFormat::kGaussianSplatting) {
    frame.picture = shown;
    if (shown.empty()) {
      EGOSIEVE_ASSIGN_OR_RETURN(frame.picture, ReadShown(index));
    }
  }
  if (!frames_.empty()) {
    const bool lies = orientation > 4;  // turned by a quarter
    const cv::Size stored = frame.picture.size();
    const cv::Size size = lies ? cv::Size(stored.height, stored.width) : stored;
    Resize(size, mask.masked);
    Resize(size, mask.numbers);
  }
  frame.masked = TurnBack(mask.masked, orientation);
  if (!mask.numbers.empty()) frame.numbers = TurnBack(mask.numbers, orientation);
  if (!frame.picture.empty() && frame.picture.size() != frame.masked.size()) {
    return OtherPicture(index, *input_.frames);
  }
  EGOSIEVE_RETURN_IF_ERROR(also_.AddTo(index, frame.masked));
  if (undistortion_) EGOSIEVE_RETURN_IF_ERROR(undistortion_->Apply(frame));
  if (options_.invert) frame.masked = frame.masked == 0;
  EGOSIEVE_RETURN_IF_ERROR(writer_.Write(frame));
  for (const int by : Reductions()) {
    EGOSIEVE_RETURN_IF_ERROR(writer_.WriteReduced(frame, by));
  }
  if (!options_.frames.empty()) {
    EGOSIEVE_RETURN_IF_ERROR(WritePicture(frame.image, file, frame.picture));
  }
  ++written_;
  return absl::OkStatus();
}

absl::StatusOr<cv::Mat3b> MaskExport::ReadShown(int64_t index) {
  vision::FrameSource& source = *input_.frames;
  if (source.next_index() != index) {
    EGOSIEVE_RETURN_IF_ERROR(AsInputError(source.SeekTo(index)));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const vision::FrameRead read, source.Next());
  const vision::Frame* frame = std::get_if<vision::Frame>(&read);
  return frame == nullptr ? cv::Mat3b(1, 1) : cv::Mat3b(frame->image);
}

// Copies a picture's file; writes a frame of a video as PNG.
absl::Status MaskExport::WritePicture(const std::string& image, const std::string& path,
                                      const cv::Mat& frame) {
  const fs::path target = fs::path(options_.frames) / image;
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(target.parent_path().string()));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes,
                            path.empty() ? EncodePng(frame) : ReadFile(path));
  return WriteFileAtomically(target.string(), bytes);
}

}  // namespace egosieve::tools
