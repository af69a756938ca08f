#include "tools/segment/segment_call.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/run_folder.h"
#include "vision/frame/av_input.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/video_file.h"

namespace egosieve::tools {
namespace {

void TellRemarks(const vision::FrameSource& frames) {
  for (const std::string& remark : frames.remarks()) Warn(remark);
  const std::vector<std::string> files = frames.files();
  if (files.empty() || vision::HasImageExtension(files.front())) return;
  for (const std::string& remark : vision::RemarksOnVideos(files)) Warn(remark);
}

}  // namespace

void SegmentCall::AddFlags(CLI::App& app) {
  app.add_option("INPUT", input,
                 "A video, a folder or a glob of images or of a drive's videos, a list of images "
                 "with their times, .txt or .csv, or a stream's address (rtsp://), which is "
                 "segmented as it comes, as with --ahead=0, until Ctrl-C")
      ->required()
      ->type_name("")
      ->configurable(false);
  app.add_option("-o,--out", directory, "The run folder to write; default: out/NAME of INPUT")
      ->type_name("DIR");
  app.add_flag("--overwrite", overwrite, "Replace the run that the folder holds");
  app.add_flag("--resume", resume,
               "Continue the run that the folder holds, with the bytes of an uninterrupted run; "
               "start it where there is none");
  app.add_flag("--record", record,
               "Keep a stream's pictures in the run folder, frames/, for refine and others");
  app.add_flag("--allow_other_device", allow_other_device,
               "With --resume: continue although the run began on another device; the log lines "
               "of the frames from here on name it");
  given.AddFlags(app);
  threads.AddFlag(app);
  device.AddFlag(app);
  progress.AddFlag(app);
  result.AddFlag(app);
}

absl::Status SegmentCall::Resolve() {
  settings = given.MakeSettings();
  if (directory.empty()) directory = DefaultFolder(input);
  EGOSIEVE_RETURN_IF_ERROR(settings.schedule.range.Validate());
  if (overwrite && resume) {
    return absl::InvalidArgumentError(
        "--overwrite and --resume exclude each other; leave one of them out");
  }
  if (allow_other_device && !resume) {
    return absl::InvalidArgumentError("--allow_other_device belongs to --resume; add that");
  }
  return settings.segmenter.Validate();
}

absl::StatusOr<DriveInput> SegmentCall::OpenInput() const {
  const Schedule& schedule = settings.schedule;
  if (!vision::IsStreamAddress(input)) {
    if (record) {
      return absl::InvalidArgumentError("--record belongs to a stream; leave it out");
    }
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput drive,
                              OpenDriveInput(input, schedule.first_frame(), schedule.source));
    TellRemarks(*drive.frames);
    return drive;
  }
  if (resume || schedule.first_frame() > 0 || schedule.frame_step() > 1 ||
      (given.Has("ahead") && settings.segmenter.ahead_frames > 0)) {
    return absl::InvalidArgumentError(
        "a stream is read once, as it comes: leave --resume, --from, --skip and --ahead out");
  }
  EGOSIEVE_ASSIGN_OR_RETURN(DriveInput drive, OpenLiveInput(input));
  if (record) {
    drive.description.path = AbsolutePath(absl::StrCat(directory, "/", RunFolder::kRecorded));
    drive.description.kind = "folder";
  }
  return drive;
}

absl::Status SegmentCall::CheckFolder(const DriveInput& drive) const {
  const std::string& source = drive.description.path;
  if (drive.description.kind == "folder" && !drive.is_live && LiesInFolder(directory, source)) {
    return absl::InvalidArgumentError(absl::StrCat("--out=", directory, " lies in what is read, ",
                                                   source, "; name another folder"));
  }
  return overwrite ? CheckApart(directory, drive.frames->files()) : absl::OkStatus();
}

}  // namespace egosieve::tools
