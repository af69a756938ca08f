#include "tools/segment/segment_command.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/threads_flag.h"
#include "tools/cli/version.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/map_image.h"
#include "tools/segment/camera_flags.h"
#include "tools/segment/drive_input.h"
#include "tools/segment/drive_writer.h"
#include "tools/segment/method_flag.h"
#include "tools/segment/method_run.h"
#include "tools/segment/resume.h"
#include "tools/segment/run_verdict.h"
#include "tools/segment/schedule_flags.h"
#include "tools/segment/segment_flags.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/live_stream.h"
#include "vision/frame/stepped_frames.h"
#include "vision/frame/video_remarks.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

class SegmentCommand : public Command {
 public:
  std::string name() const override { return "segment"; }
  std::string summary() const override {
    return "Segments a drive: maps of what moves by itself, and a line of the log per frame.";
  }
  std::string example() const override {
    return "egosieve segment drive.mp4 --out=out/drive\n"
           "egosieve segment 'frames/*.png' --out=out/frames --stride=3 --profile=paper";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("INPUT", input_,
                   "A video, a folder or a glob of images or of a drive's videos, a list of images "
                   "with their times, .txt or .csv, or a stream's address (rtsp://), which is "
                   "segmented as it comes, as with --ahead=0, until Ctrl-C")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--out", directory_, "The run folder to write")->required()->type_name("DIR");
    app.add_flag("--overwrite", overwrite_, "Replace the run that the folder holds");
    app.add_flag("--resume", resume_,
                 "Continue the run that the folder holds, with the bytes of an uninterrupted run; "
                 "start it where there is none");
    app.add_flag("--record", record_,
                 "Keep a stream's pictures in the run folder, frames/, for reconstruct and others");
    app.add_flag("--allow_other_device", allow_other_device_,
                 "With --resume: continue although the run began on another device; the log lines "
                 "of the frames from here on name it");
    flags_.AddFlags(app);
    camera_.AddFlags(app);
    method_.AddFlag(app);
    schedule_.AddFlags(app);
    threads_.AddFlag(app);
    device_.AddFlag(app);
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_RETURN_IF_ERROR(schedule_.Validate());
    if (overwrite_ && resume_) {
      return absl::InvalidArgumentError(
          "--overwrite and --resume exclude each other; leave one of them out");
    }
    if (allow_other_device_ && !resume_) {
      return absl::InvalidArgumentError("--allow_other_device belongs to --resume; add that");
    }
    const int threads = threads_.Apply();
    vision::OnlineSegmenterOptions options = flags_.MakeOptions(threads);
    method_.Apply(options);
    EGOSIEVE_RETURN_IF_ERROR(options.Validate());
    EGOSIEVE_RETURN_IF_ERROR(method_.CheckWith(resume_, schedule_.LeavesMaps()));
    if (method_.is_rival() && options.potential.enabled) {
      return absl::InvalidArgumentError(
          "--potential belongs to the segmenter; leave it or --method out");
    }
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenInput());
    if (input.is_live) options.ahead_frames = 0;
    TellRemarks(*input.frames);
    EGOSIEVE_RETURN_IF_ERROR(camera_.Read(input));
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, device_.Open());
    EGOSIEVE_RETURN_IF_ERROR(CheckFolder(input));
    if (InterruptionRequested()) {
      return absl::CancelledError("interrupted; nothing was written");
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<FolderLock> lock, LockFolder());
    // Before the folder is replaced: interrupting the first pass keeps the former run.
    EGOSIEVE_RETURN_IF_ERROR(
        camera_.Find(input, schedule_.first_frame(), resume_, directory_, options.labeller));
    if (schedule_.frame_step() > 1) {
      input.frames = std::make_unique<vision::SteppedFrames>(
          std::move(input.frames), schedule_.first_frame(), schedule_.frame_step());
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<RunFolder> created, CreateUnlessResumed());
    if (method_.is_rival()) return SegmentByRival(input, device, options, *created);
    EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<vision::OnlineSegmenter> segmenter,
                              vision::OnlineSegmenter::Create(device.context, options));
    EGOSIEVE_ASSIGN_OR_RETURN(Beginning beginning, Begin(Describe(input, device.info, options),
                                                         created, input, *segmenter));
    if (!beginning.writer) {
      Tell(*beginning.counts, 0.0, absl::StrCat(directory_, " holds the whole run already\n"));
      return Judge(*beginning.counts, beginning.warning, input);
    }
    return Segment(input, schedule_.MakePipeline(threads, beginning.first_frame), *segmenter,
                   *beginning.writer);
  }

 private:
  struct Beginning {
    std::optional<DriveWriter> writer;  // absent: the run is done, see below
    int64_t first_frame = 0;
    std::optional<DriveWriter::Counts> counts;  // only of a run that is done
    std::string warning;                        // of the input's end
  };

  absl::StatusOr<DriveInput> OpenInput() const {
    if (!vision::IsStreamAddress(input_)) {
      if (record_) {
        return absl::InvalidArgumentError("--record belongs to a stream; leave it out");
      }
      return OpenDriveInput(input_, schedule_.first_frame(), schedule_.source());
    }
    if (resume_ || schedule_.first_frame() > 0 || schedule_.LeavesMaps() ||
        schedule_.frame_step() > 1 || flags_.wants_frames_ahead()) {
      return absl::InvalidArgumentError(
          "a stream is read once, as it comes: leave --resume, --from, "
          "--skip, --learn_only, --every and --ahead out");
    }
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenLiveInput(input_));
    if (record_) {
      input.description.path = AbsolutePath(absl::StrCat(directory_, "/", RunFolder::kRecorded));
      input.description.kind = "folder";
    }
    return input;
  }

  // Maps must not become pictures of the input, and --overwrite must not remove its pictures.
  absl::Status CheckFolder(const DriveInput& input) const {
    const std::string& source = input.description.path;
    if (input.description.kind == "folder" && !input.is_live && LiesInFolder(directory_, source)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--out=", directory_, " lies in what is read, ", source, "; name another folder"));
    }
    return overwrite_ ? CheckApart(directory_, input.frames->files()) : absl::OkStatus();
  }

  static void TellRemarks(const vision::FrameSource& frames) {
    const std::vector<std::string> files = frames.files();
    if (files.empty() || vision::HasImageExtension(files.front())) return;
    for (const std::string& remark : vision::RemarksOnVideos(files)) Warn(remark);
  }

  // Absent if --out is not a folder, which RunFolder reports as an error.
  absl::StatusOr<std::optional<FolderLock>> LockFolder() const {
    std::error_code error;
    if (!fs::exists(directory_, error)) EGOSIEVE_RETURN_IF_ERROR(CreateFolder(directory_));
    if (!fs::is_directory(directory_, error)) return std::nullopt;
    EGOSIEVE_ASSIGN_OR_RETURN(FolderLock lock, FolderLock::Take(directory_));
    return std::optional<FolderLock>(std::move(lock));
  }

  // Absent if --resume finds a run.
  absl::StatusOr<std::optional<RunFolder>> CreateUnlessResumed() const {
    if (resume_ && RunFolder::Open(directory_).ok()) return std::optional<RunFolder>();
    EGOSIEVE_ASSIGN_OR_RETURN(RunFolder folder, RunFolder::Create(directory_, overwrite_));
    return std::make_optional(std::move(folder));
  }

  // A new run folder, or the state of the run that --resume has found.
  absl::StatusOr<Beginning> Begin(RunDescription description,
                                  const std::optional<RunFolder>& created, DriveInput& input,
                                  vision::OnlineSegmenter& segmenter) const {
    Beginning beginning;
    beginning.first_frame = schedule_.first_frame();
    if (created) {
      EGOSIEVE_ASSIGN_OR_RETURN(beginning.writer, Start(*created, description));
      return beginning;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(directory_));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription before, folder.ReadDescription());
    const std::string device = description.device;
    if (allow_other_device_) description.device = before.device;
    EGOSIEVE_RETURN_IF_ERROR(
        CheckSameRun(before, description, before.device != device, directory_));
    RemoveAbandonedFiles(folder);
    EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, ReadWholeLines(folder, before));
    if (before.ended == "done" && IsComplete(lines, *input.frames, beginning.warning)) {
      beginning.counts.emplace(before);
      for (const FrameLine& line : lines) beginning.counts->Add(line);
      const int64_t end = lines.empty() ? schedule_.first_frame() : lines.back().index + 1;
      EGOSIEVE_RETURN_IF_ERROR(RemoveOtherCheckpoints(folder, before, end));
      return beginning;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const ResumePoint point,
                              FindResumePoint(folder, schedule_.first_frame(), std::move(lines)));
    EGOSIEVE_RETURN_IF_ERROR(RemoveOtherCheckpoints(folder, before, point.next_frame));
    if (!point.checkpoint.empty()) {
      EGOSIEVE_ASSIGN_OR_RETURN(
          const std::vector<vision::Frame> recent,
          ReadRecentFrames(*input.frames, schedule_.first_frame(), point.next_frame - 1,
                           segmenter.options().labeller.HistoryFrames()));
      EGOSIEVE_RETURN_IF_ERROR(segmenter.Restore(point.checkpoint, recent));
    }
    description.started_utc = before.started_utc;
    description.seconds = before.seconds;
    beginning.first_frame = point.next_frame;
    EGOSIEVE_ASSIGN_OR_RETURN(
        beginning.writer,
        DriveWriter::Continue(folder, description, point.lines, WriterOptions(device)));
    // A kill may have prevented writing it before.
    EGOSIEVE_RETURN_IF_ERROR(camera_.Write(directory_));
    return beginning;
  }

  absl::StatusOr<DriveWriter> Start(const RunFolder& folder,
                                    const RunDescription& description) const {
    EGOSIEVE_ASSIGN_OR_RETURN(
        DriveWriter writer,
        DriveWriter::Start(folder, description, WriterOptions(description.device)));
    EGOSIEVE_RETURN_IF_ERROR(camera_.Write(directory_));
    return writer;
  }

  bool IsComplete(const std::vector<FrameLine>& lines, vision::FrameSource& source,
                  std::string& warning) const {
    const int64_t from = schedule_.first_frame(), step = schedule_.frame_step();
    const int64_t next = lines.empty() ? from : lines.back().index + step;
    return tools::IsComplete(next, step, schedule_.MakePipeline(1, from).end_frame, source,
                             warning);
  }

  absl::StatusOr<ExitCode> Segment(const DriveInput& input, const vision::PipelineOptions& pipeline,
                                   vision::OnlineSegmenter& segmenter, DriveWriter& writer) const {
    return WriteAll(input, pipeline, writer, [&](const vision::SegmentedFrameSink& sink) {
      return vision::RunPipeline(*input.frames, segmenter, pipeline, InterruptionRequested, sink);
    });
  }

  absl::StatusOr<ExitCode> SegmentByRival(const DriveInput& input, const OpenedDevice& device,
                                          const vision::OnlineSegmenterOptions& options,
                                          const RunFolder& folder) const {
    EGOSIEVE_ASSIGN_OR_RETURN(
        std::unique_ptr<vision::MethodSegmenter> segmenter,
        vision::MethodSegmenter::Create(device.context, options, {method_.name()}));
    RunDescription description = Describe(input, device.info, options);
    description.flags["method"] = method_.name();
    EGOSIEVE_ASSIGN_OR_RETURN(DriveWriter writer, Start(folder, description));
    vision::PipelineOptions pipeline = schedule_.MakePipeline(1, schedule_.first_frame());
    pipeline.checkpoint_interval = 0;
    return WriteAll(input, pipeline, writer, [&](const vision::SegmentedFrameSink& sink) {
      return RunMethod(*input.frames, *segmenter, pipeline, InterruptionRequested, sink);
    });
  }

  // Writes the frames that `run` gives to its sink, and how the run ended.
  template <typename Run>
  absl::StatusOr<ExitCode> WriteAll(const DriveInput& input,
                                    const vision::PipelineOptions& pipeline, DriveWriter& writer,
                                    const Run& run) const {
    Progress progress("segment", progress_, ExpectedFrames(*input.frames, pipeline));
    std::optional<double> first_seconds;  // of the drive
    const absl::StatusOr<vision::PipelineSummary> summary =
        run([&](const vision::SegmentedFrame& frame) {
          if (record_) EGOSIEVE_RETURN_IF_ERROR(Record(frame));
          EGOSIEVE_RETURN_IF_ERROR(writer.Write(frame, input.frames->image_name(frame.index)));
          const FrameLine& line = writer.last_line();
          if (!first_seconds) first_seconds = line.time_seconds;
          progress.Advance(
              {{"times real time", (line.time_seconds - *first_seconds) / progress.Seconds()},
               {"model size", static_cast<double>(line.model_size)},
               {"dynamic share", line.dynamic_share}});
          return absl::OkStatus();
        });
    progress.Finish();
    return End(summary, input, progress.Seconds(), writer);
  }

  // A frame that could not be read keeps its index: its file will be unreadable, too.
  absl::Status Record(const vision::SegmentedFrame& frame) const {
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(directory_));
    EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File(RunFolder::kRecorded)));
    std::string png;
    if (!frame.damage.has_value()) {
      EGOSIEVE_ASSIGN_OR_RETURN(png, EncodePng(frame.frame.image));
    }
    return WriteFileAtomically(folder.FrameFile(RunFolder::kRecorded, frame.index, ".png"), png);
  }

  RunDescription Describe(const DriveInput& input, const kernels::DeviceInfo& device,
                          const vision::OnlineSegmenterOptions& options) const {
    RunDescription description;
    description.version = kVersion;
    description.flags = DescribeOptions(options);
    camera_.Describe(description.flags);
    schedule_.Describe(description.flags);
    description.device = DescribeDevice(device);
    description.seed = flags_.seed();
    description.input = input.description;
    description.grid = {input.width_pixels, input.height_pixels, options.stride_pixels};
    description.started_utc = UtcNow();
    return description;
  }

  DriveWriterOptions WriterOptions(const std::string& device) const {
    return {schedule_.WantedMaps(), schedule_.LeavesMaps(), device};
  }

  absl::StatusOr<ExitCode> End(const absl::StatusOr<vision::PipelineSummary>& summary,
                               const DriveInput& input, double seconds, DriveWriter& writer) const {
    if (!summary.ok()) {
      // This error is returned; if run.json cannot be written, it keeps saying "running".
      writer.Finish("failed", std::string(summary.status().message()), seconds).IgnoreError();
      return summary.status();
    }
    // A stream ends when its reader stops.
    const bool is_cut_short = summary->stopped && !input.is_live;
    EGOSIEVE_RETURN_IF_ERROR(writer.Finish(is_cut_short ? "interrupted" : "done", "", seconds));
    const DriveWriter::Counts& counts = writer.counts();
    std::string text =
        absl::StrFormat("%d frames answered, %d learnt from, in %s: %s\n", counts.answered,
                        counts.learnt, DescribeDuration(seconds), directory_);
    if (schedule_.LeavesMaps()) {
      absl::StrAppend(&text, "egosieve infer ", directory_, " makes the maps that were left out\n");
    }
    if (counts.doubtful.count() > 0) absl::StrAppend(&text, counts.doubtful.Sentence(), "\n");
    Tell(counts, seconds, text);
    if (is_cut_short) {
      return absl::CancelledError(absl::StrCat("interrupted; the ", counts.answered + counts.failed,
                                               " frames in ", directory_,
                                               " are whole, --resume goes on"));
    }
    return Judge(counts, summary->warning, input);
  }

  void Tell(const DriveWriter::Counts& counts, double seconds, const std::string& text) const {
    result_.Tell(name(),
                 {{"run", directory_},
                  {"frames_answered", counts.answered},
                  {"frames_learnt", counts.learnt},
                  {"frames_failed", counts.failed},
                  {"pairs_far_apart", counts.baselines.far_apart()},
                  {"frames_unreliable", counts.doubtful.count()},
                  {"seconds", seconds}},
                 text);
  }

  // The same for a run that has just ended and for one that was finished before.
  static ExitCode Judge(const DriveWriter::Counts& counts, const std::string& warning,
                        const DriveInput& input) {
    const RunVerdict verdict = JudgeRun(counts, warning, *input.frames);
    for (const std::string& text : verdict.warnings) Warn(text);
    return verdict.code;
  }

  std::string input_, directory_;
  bool overwrite_ = false;
  bool resume_ = false;
  bool allow_other_device_ = false;
  bool record_ = false;
  SegmentFlags flags_;
  CameraFlags camera_;
  MethodFlag method_;
  ScheduleFlags schedule_;
  ThreadsFlag threads_;
  DeviceFlag device_;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeSegmentCommand() { return std::make_unique<SegmentCommand>(); }

}  // namespace egosieve::tools
