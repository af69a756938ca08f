#include "tools/segment/segment_camera.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/progress.h"
#include "tools/run_folder/map_image.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/lens_file.h"
#include "vision/frame/frame_source.h"
#include "vision/frame/ignored_area.h"
#include "vision/labelling/drive_camera.h"
#include "vision/labelling/drive_pictures.h"
#include "vision/labelling/shots.h"

namespace egosieve::tools {
namespace {

// Passes on another source's frames, counts them, and returns the error Cancelled when the program
// is asked to stop. For passes over a drive that write nothing.
class InterruptibleSource : public vision::FrameSource {
 public:
  InterruptibleSource(vision::FrameSource& source, Progress& progress)
      : source_(source), progress_(progress) {}

  absl::StatusOr<vision::FrameRead> Next() override {
    if (!progress_.AdvanceUninterrupted()) {
      return absl::CancelledError("interrupted before the first frame; nothing was written");
    }
    return source_.Next();
  }
  absl::Status SeekTo(int64_t index) override { return source_.SeekTo(index); }
  int64_t next_index() const override { return source_.next_index(); }
  int64_t expected_frame_count() const override { return source_.expected_frame_count(); }
  std::string description() const override { return source_.description(); }

 private:
  vision::FrameSource& source_;
  Progress& progress_;
};

}  // namespace

absl::StatusOr<SegmentCamera::UsedLens> SegmentCamera::UseLens(const LensFile& given,
                                                               cv::Size frames) {
  UsedLens used;
  used.ratio = given.focal_ratio();
  if (given.is_pinhole()) return used;
  LensFile file = given;
  EGOSIEVE_RETURN_IF_ERROR(ScaleTo(frames, file));
  EGOSIEVE_ASSIGN_OR_RETURN(const vision::LensCorrection lens,
                            vision::LensCorrection::Create(file.lens, frames));
  if (lens.IsIdentity()) return used;
  used.ratio = lens.focal_pixels() / std::max(frames.width, frames.height);
  used.correction = std::make_shared<vision::LensCorrection>(lens);
  used.file = file;
  return used;
}

absl::Status SegmentCamera::Read(const CameraSettings& settings, const DriveInput& input) {
  settings_ = settings;
  if (!settings_.lens.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(const LensFile file, ReadLensFile(settings_.lens));
    const auto used = UseLens(file, {input.width_pixels, input.height_pixels});
    if (!used.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--camera=", settings_.lens, ": ", used.status().message()));
    }
    given_ = *used;
  }
  if (settings_.ignore.empty()) return absl::OkStatus();
  const absl::StatusOr<cv::Mat> read = ReadImage(settings_.ignore, cv::IMREAD_GRAYSCALE);
  if (!read.ok()) {
    return absl::Status(read.status().code(),
                        absl::StrCat("--ignore takes one image: ", read.status().message()));
  }
  const cv::Mat& image = *read;
  if (image.cols != input.width_pixels || image.rows != input.height_pixels) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s is %dx%d, the frames are %dx%d; give a mask of the frames' size", settings_.ignore,
        image.cols, image.rows, input.width_pixels, input.height_pixels));
  }
  ignored_ = image != 0;
  return absl::OkStatus();
}

absl::Status SegmentCamera::Find(const DriveInput& input, int64_t from, int64_t end, bool resumes,
                                 const std::string& directory, const ProgressFlag& shown,
                                 vision::FrameLabellerOptions& labeller) {
  if (!(labeller.focal_ratio > 0.0)) {
    labeller.focal_ratio = given_.ratio;
    if (labeller.WantsCamera()) labeller.lens = given_.correction;
  }
  is_ratio_given_ = labeller.focal_ratio > 0.0;
  labeller.ignored = ignored_;
  if (!labeller.WantsCamera() || (is_ratio_given_ && !settings_.finds_own_vehicle))
    return absl::OkStatus();
  if (input.is_live || !settings_.has_first_pass) {  // a stream allows none
    learns_ = labeller.LearnsFocalRatio();
    return absl::OkStatus();
  }
  // As for the whole input, so that a longer run can go on.
  if (end >= 0) end = std::max(end, from + vision::kLongestDriveFrames);
  if (resumes) {
    EGOSIEVE_ASSIGN_OR_RETURN(cameras_, ReadRunCameras(directory));
  }
  const bool are_known = cameras_.end < 0 || (end >= 0 && end <= cameras_.end);
  if (cameras_.shots.empty() || !are_known) {
    EGOSIEVE_RETURN_IF_ERROR(Learn(input, from, end, shown, labeller));
  }
  const vision::FrameLabellerOptions given = labeller;
  const cv::Size frames(input.width_pixels, input.height_pixels);
  for (const auto& [first_frame, camera] : cameras_.shots) {
    vision::FrameLabellerOptions& shot =
        first_frame == 0 ? labeller : labeller.later_shots.emplace_back(given);
    shot.first_frame = first_frame;
    EGOSIEVE_RETURN_IF_ERROR(SetCamera(camera, frames, shot));
  }
  return absl::OkStatus();
}

absl::Status SegmentCamera::SetCamera(const RunCamera& camera, cv::Size frames,
                                      vision::FrameLabellerOptions& labeller) const {
  if (!is_ratio_given_) {
    EGOSIEVE_ASSIGN_OR_RETURN(const UsedLens used, UseLens(camera.lens, frames));
    labeller.focal_ratio = used.ratio;
    labeller.lens = used.correction;
  }
  labeller.travel = camera.travel;
  labeller.fixed_pattern = camera.fixed_pattern;
  labeller.windscreen = camera.windscreen;
  if (!camera.own_vehicle.empty()) {
    labeller.ignored = vision::United(ignored_, camera.own_vehicle);
  }
  return absl::OkStatus();
}

absl::Status SegmentCamera::Learn(const DriveInput& input, int64_t from, int64_t end,
                                  const ProgressFlag& shown,
                                  const vision::FrameLabellerOptions& labeller) {
  const cv::Size frames(input.width_pixels, input.height_pixels);
  Progress progress("first pass", shown, -1);
  InterruptibleSource source(*input.frames, progress);
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> shots, vision::FindShots(source, from, end));
  cameras_.end = end;
  vision::DriveCameraOptions options;
  options.pictures.equalization = labeller.equalization;
  options.pictures.ignored = ignored_;
  options.pictures.lens = labeller.lens;
  options.focal_ratio = labeller.focal_ratio;
  options.finds_own_vehicle = settings_.finds_own_vehicle;
  std::optional<RunCamera> whole;
  for (size_t k = 0; k < shots.size(); ++k) {
    const int64_t name = k == 0 ? 0 : shots[k];
    if (cameras_.shots.contains(name)) continue;
    options.pictures.first_frame = shots[k];
    options.pictures.end_frame = k + 1 < shots.size() ? shots[k + 1] : -1;
    RunCamera& camera = cameras_.shots[name];
    EGOSIEVE_ASSIGN_OR_RETURN(camera, LearnShot(source, options, frames));
    if (shots.size() == 1 || camera.pair_count >= vision::TravelPrior::kFewestDirections) continue;
    if (!whole) {
      options.pictures.first_frame = from;
      options.pictures.end_frame = -1;
      EGOSIEVE_ASSIGN_OR_RETURN(whole, LearnShot(source, options, frames));
    }
    if (whole->travel.IsOfVehicle()) camera = *whole;
  }
  return absl::OkStatus();
}

absl::StatusOr<RunCamera> SegmentCamera::LearnShot(vision::FrameSource& source,
                                                   vision::DriveCameraOptions options,
                                                   cv::Size frames) const {
  // The picture beside a cut may show both scenes.
  const int64_t first = options.pictures.first_frame + 1;
  EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(first));
  EGOSIEVE_ASSIGN_OR_RETURN(vision::DriveCamera camera, vision::LearnDriveCamera(source, options));
  UsedLens lens = given_;
  if (camera.lens) {
    // Once more, of the corrected pictures.
    EGOSIEVE_ASSIGN_OR_RETURN(lens, UseLens({*camera.lens, frames}, frames));
    options.pictures.lens = lens.correction;
    options.focal_ratio = lens.ratio;
    EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(first));
    const double deviation = camera.log_focal_deviation;
    EGOSIEVE_ASSIGN_OR_RETURN(camera, vision::LearnDriveCamera(source, options));
    camera.log_focal_deviation = deviation;
  }
  return MakeRunCamera(camera, frames, lens.file ? &*lens.file : nullptr);
}

void SegmentCamera::Describe(std::map<std::string, std::string>& flags) const {
  // The results of a first pass follow from the input, so they are not described.
  if (!cameras_.shots.empty() && !is_ratio_given_) flags["focal_ratio"] = "learnt";
  if (learns_) flags["focal_ratio"] = "learnt on the way";
  if (!ignored_.empty()) flags["ignore"] = Fingerprint(ignored_);
}

absl::Status SegmentCamera::Write(const std::string& directory) const {
  if (!ignored_.empty()) {
    EGOSIEVE_RETURN_IF_ERROR(WritePng(absl::StrCat(directory, "/", RunFolder::kIgnored), ignored_));
  }
  return cameras_.shots.empty() ? absl::OkStatus() : WriteRunCameras(directory, cameras_);
}

absl::Status SegmentCamera::WriteLearnt(const std::string& directory, const DriveInput& input,
                                        const vision::LearntCamera& learnt) const {
  if (!(learnt.focal_ratio > 0.0)) return absl::OkStatus();
  vision::DriveCamera camera;
  camera.focal_ratio = learnt.focal_ratio;
  camera.log_focal_deviation = learnt.log_focal_deviation;
  camera.travel = learnt.travel;
  RunCameras cameras;
  EGOSIEVE_ASSIGN_OR_RETURN(cameras.shots[0],
                            MakeRunCamera(camera, {input.width_pixels, input.height_pixels}));
  return WriteRunCameras(directory, cameras);
}

}  // namespace egosieve::tools
