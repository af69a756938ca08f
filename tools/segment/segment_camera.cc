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

absl::Status SegmentCamera::UseLens(const LensFile& given, cv::Size frames) {
  ratio_ = given.focal_ratio();
  if (given.is_pinhole()) return absl::OkStatus();
  LensFile file = given;
  EGOSIEVE_RETURN_IF_ERROR(ScaleTo(frames, file));
  EGOSIEVE_ASSIGN_OR_RETURN(const vision::LensCorrection lens,
                            vision::LensCorrection::Create(file.lens, frames));
  if (lens.IsIdentity()) return absl::OkStatus();
  ratio_ = lens.focal_pixels() / std::max(frames.width, frames.height);
  lens_ = std::make_shared<vision::LensCorrection>(lens);
  file_ = file;
  return absl::OkStatus();
}

absl::Status SegmentCamera::Read(const CameraSettings& settings, const DriveInput& input) {
  settings_ = settings;
  if (!settings_.lens.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(const LensFile file, ReadLensFile(settings_.lens));
    const absl::Status used = UseLens(file, {input.width_pixels, input.height_pixels});
    if (!used.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--camera=", settings_.lens, ": ", used.message()));
    }
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

absl::Status SegmentCamera::Find(const DriveInput& input, int64_t from, bool resumes,
                                 const std::string& directory, const ProgressFlag& shown,
                                 vision::FrameLabellerOptions& labeller) {
  if (!(labeller.focal_ratio > 0.0)) {
    labeller.focal_ratio = ratio_;
    if (labeller.WantsCamera()) labeller.lens = lens_;
  }
  is_ratio_given_ = labeller.focal_ratio > 0.0;
  labeller.ignored = ignored_;
  if (!labeller.WantsCamera() || (is_ratio_given_ && !settings_.finds_own_vehicle))
    return absl::OkStatus();
  if (input.is_live || !settings_.has_first_pass) {  // a stream allows none
    learns_ = labeller.LearnsFocalRatio();
    return absl::OkStatus();
  }
  if (resumes) {
    EGOSIEVE_ASSIGN_OR_RETURN(camera_, ReadRunCamera(directory));
  }
  if (!camera_) {
    EGOSIEVE_ASSIGN_OR_RETURN(camera_, Learn(input, from, shown, labeller));
  }
  if (!is_ratio_given_) {
    EGOSIEVE_RETURN_IF_ERROR(UseLens(camera_->lens, {input.width_pixels, input.height_pixels}));
    labeller.focal_ratio = ratio_;
    labeller.lens = lens_;
  }
  labeller.travel = camera_->travel;
  labeller.fixed_pattern = camera_->fixed_pattern;
  labeller.windscreen = camera_->windscreen;
  if (!camera_->own_vehicle.empty()) {
    labeller.ignored = vision::United(ignored_, camera_->own_vehicle);
  }
  return absl::OkStatus();
}

absl::StatusOr<RunCamera> SegmentCamera::Learn(const DriveInput& input, int64_t from,
                                               const ProgressFlag& shown,
                                               const vision::FrameLabellerOptions& labeller) {
  const cv::Size frames(input.width_pixels, input.height_pixels);
  vision::DriveCameraOptions options;
  options.pictures.first_frame = from;
  options.pictures.equalization = labeller.equalization;
  options.pictures.ignored = ignored_;
  options.pictures.lens = labeller.lens;
  options.focal_ratio = labeller.focal_ratio;
  options.finds_own_vehicle = settings_.finds_own_vehicle;
  Progress progress("first pass", shown, -1);
  InterruptibleSource source(*input.frames, progress);
  EGOSIEVE_ASSIGN_OR_RETURN(vision::DriveCamera camera, vision::LearnDriveCamera(source, options));
  if (camera.lens) {
    // Once more, of the corrected pictures.
    EGOSIEVE_RETURN_IF_ERROR(UseLens({*camera.lens, frames}, frames));
    options.pictures.lens = lens_;
    options.focal_ratio = ratio_;
    EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(from));
    const double deviation = camera.log_focal_deviation;
    EGOSIEVE_ASSIGN_OR_RETURN(camera, vision::LearnDriveCamera(source, options));
    camera.log_focal_deviation = deviation;
  }
  return MakeRunCamera(camera, frames, file_ ? &*file_ : nullptr);
}

void SegmentCamera::Describe(std::map<std::string, std::string>& flags) const {
  // The results of a first pass follow from the input, so they are not described.
  if (camera_ && !is_ratio_given_) flags["focal_ratio"] = "learnt";
  if (learns_) flags["focal_ratio"] = "learnt on the way";
  if (!ignored_.empty()) flags["ignore"] = Fingerprint(ignored_);
}

absl::Status SegmentCamera::Write(const std::string& directory) const {
  if (!ignored_.empty()) {
    EGOSIEVE_RETURN_IF_ERROR(WritePng(absl::StrCat(directory, "/", RunFolder::kIgnored), ignored_));
  }
  return camera_ ? WriteRunCamera(directory, *camera_) : absl::OkStatus();
}

absl::Status SegmentCamera::WriteLearnt(const std::string& directory, const DriveInput& input,
                                        const vision::LearntCamera& learnt) const {
  if (!(learnt.focal_ratio > 0.0)) return absl::OkStatus();
  vision::DriveCamera camera;
  camera.focal_ratio = learnt.focal_ratio;
  camera.log_focal_deviation = learnt.log_focal_deviation;
  camera.travel = learnt.travel;
  EGOSIEVE_ASSIGN_OR_RETURN(const RunCamera run,
                            MakeRunCamera(camera, {input.width_pixels, input.height_pixels}));
  return WriteRunCamera(directory, run);
}

}  // namespace egosieve::tools
