#include "tools/segment/segment_run.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gp/io/array_file.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/device.h"
#include "tools/cli/command.h"
#include "tools/cli/interruption.h"
#include "tools/cli/version.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/map_image.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/drive_writer.h"
#include "tools/segment/resume.h"
#include "tools/segment/segment_call.h"
#include "vision/frame/equalization.h"
#include "vision/frame/stepped_frames.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {
namespace {

// How a run of `segment` begins: in a new run folder, or where the run that --resume finds there
// stopped.
struct RunBeginning {
  std::optional<DriveWriter> writer;  // absent: the run is done, see below
  int64_t first_frame = 0;
  std::optional<DriveWriter::Counts> counts;  // only of a run that is done
  std::string warning;                        // of the input's end
};

// Whether a run that ended has all its frames; one that goes beyond what is wanted is a warning.
// warning: of the source's end, if that is the run's. Leaves the source at any frame.
bool HasAllFrames(const Schedule& schedule, const std::vector<FrameLine>& lines,
                  vision::FrameSource& source, std::string& warning) {
  const int64_t from = schedule.first_frame(), step = schedule.frame_step();
  const int64_t next = lines.empty() ? from : lines.back().index + step;
  const int64_t end = schedule.MakePipeline(1, from).end_frame;
  if (end < 0 || next < end) {
    if (!source.SeekTo(next).ok()) return false;
    const absl::StatusOr<vision::FrameRead> read = source.Next();
    if (!read.ok() || !std::holds_alternative<vision::EndOfFrames>(*read)) return false;
    warning = std::get<vision::EndOfFrames>(*read).warning;
  } else if (next >= end + step) {
    Warn(absl::StrCat("the run goes on to frame ", next - step,
                      " already, beyond what --max_frames or --to asks for; its frames stay"));
  }
  return true;
}

// A new run folder; absent if --resume finds a run. Errors of RunFolder::Create.
absl::StatusOr<std::optional<RunFolder>> CreateUnlessResumed(const SegmentCall& call) {
  if (call.resume && RunFolder::Open(call.directory).ok()) return std::optional<RunFolder>();
  EGOSIEVE_ASSIGN_OR_RETURN(RunFolder folder, RunFolder::Create(call.directory, call.overwrite));
  return std::make_optional(std::move(folder));
}

// The run that the call makes, at its start.
RunDescription DescribeRun(const SegmentCall& call, const DriveInput& input,
                           const kernels::DeviceInfo& device) {
  RunDescription description;
  description.version = kVersion;
  description.flags = DescribeSettings(call.settings);
  call.camera.Describe(description.flags);
  description.device = DescribeDevice(device);
  description.seed = call.settings.segmenter.labeller.seed;
  description.input = input.description;
  description.grid = {input.width_pixels, input.height_pixels,
                      call.settings.segmenter.stride_pixels};
  description.started_utc = UtcNow();
  return description;
}

// Continues the run of --resume and restores the segmenter's state. FailedPrecondition if that run
// differs from `description`; errors of resume.h. Leaves the input at any frame.
absl::StatusOr<RunBeginning> ContinueRun(const SegmentCall& call, RunDescription description,
                                         vision::FrameSource& frames,
                                         vision::OnlineSegmenter& segmenter) {
  RunBeginning beginning;
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(call.directory));
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription before, folder.ReadDescription());
  const std::string device = description.device;
  if (call.allow_other_device) description.device = before.device;
  if (const std::string difference = DescribeDifference(before, description); !difference.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the run in ", call.directory, " is another: ", difference,
        before.device != device ? "; give it the same, choose another folder for --out, or add "
                                  "--allow_other_device"
                                : "; give it the same, or choose another folder for --out"));
  }
  RemoveAbandonedFiles(folder.path());
  const int64_t from = call.settings.schedule.first_frame();
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, ReadWholeLines(folder));
  if (before.ended == "done" &&
      HasAllFrames(call.settings.schedule, lines, frames, beginning.warning)) {
    beginning.counts.emplace(before);
    for (const FrameLine& line : lines) beginning.counts->Add(line);
    const int64_t end = lines.empty() ? from : lines.back().index + 1;
    EGOSIEVE_RETURN_IF_ERROR(RemoveOtherCheckpoints(folder, end));
    return beginning;
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const ResumePoint point,
                            FindResumePoint(folder, from, std::move(lines)));
  EGOSIEVE_RETURN_IF_ERROR(RemoveOtherCheckpoints(folder, point.next_frame));
  if (!point.checkpoint.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<vision::Frame> recent,
                              ReadRecentFrames(frames, from, point.next_frame - 1,
                                               segmenter.options().labeller.HistoryFrames()));
    EGOSIEVE_RETURN_IF_ERROR(segmenter.Restore(point.checkpoint, recent));
  }
  description.started_utc = before.started_utc;
  description.seconds = before.seconds;
  beginning.first_frame = point.next_frame;
  EGOSIEVE_ASSIGN_OR_RETURN(beginning.writer,
                            DriveWriter::Open(folder, description, point.lines, device));
  // A kill may have prevented writing it before.
  EGOSIEVE_RETURN_IF_ERROR(call.camera.Write(call.directory));
  return beginning;
}

// Writes what a frame's map is learnt from and evaluated on, for classifiers outside the program
// (tools/evaluate/compare.py).

constexpr int64_t kInputs = vision::kBoxMeanColumns;

template <typename Number>
gp::NamedArray Table(const std::vector<Number>& elements, int64_t columns) {
  const int64_t rows = static_cast<int64_t>(elements.size()) / columns;
  return {{rows, columns}, std::vector<double>(elements.begin(), elements.end())};
}

// Writes DIRECTORY/NNNNNN.npz for a frame with a picture; nothing for a damaged one. The directory
// exists. For N labelled places and the G pixels of the map's grid, row by row:
//
//   frames     4      indices of this frame, of the labelled one and of the pair's two; -1: none
//   grid       3      width and height of the picture and stride of the grid, pixels
//   labels     N      probability of moving, in [0, 1]
//   inputs     N x 6  descriptors of the labelled places (vision/image/box_means.h)
//   field      G x 6  descriptors of the grid in this frame
//   positions  N x 2  places in the labelled frame, pixels
//   others     N x 2  the same places in the pair's other frame
//   kind       1      of motion: 0 none, 1 static, 2 homography, 3 fundamental matrix
absl::Status DumpFeatures(const vision::SegmentedFrame& frame,
                          const vision::OnlineSegmenterOptions& options,
                          const std::string& directory) {
  if (frame.damage.has_value()) return absl::OkStatus();
  const vision::LabelledFrame& labels = frame.labels;
  const auto equalized = [&](const vision::Frame& picture) {
    return vision::EqualizeLuminance(picture.image, options.labeller.equalization);
  };
  const cv::Size size = frame.frame.image.size();
  const vision::ImageGrid grid{size.width, size.height, options.stride_pixels};
  const std::vector<float> field =
      vision::BoxMeansOnGrid(vision::ViewOf(equalized(frame.frame)), grid, options.window_pixels);
  std::vector<float> inputs;
  if (labels.size() > 0) {
    EGOSIEVE_ASSIGN_OR_RETURN(inputs,
                              vision::BoxMeansAt(vision::ViewOf(equalized(labels.labelled)),
                                                 labels.positions_view(), options.window_pixels));
  }
  const gp::ArrayMap arrays = {
      {"frames", gp::VectorArray<int64_t>({frame.index, labels.labelled.index, labels.first_index,
                                           labels.second_index})},
      {"grid", gp::VectorArray<int64_t>({grid.width, grid.height, grid.stride})},
      {"labels", gp::VectorArray(labels.probability)},
      {"inputs", Table(inputs, kInputs)},
      {"field", Table(field, kInputs)},
      {"positions", Table(labels.positions, 2)},
      {"others", Table(labels.other_positions, 2)},
      {"kind", gp::VectorArray<int64_t>({static_cast<int64_t>(labels.motion_model)})},
  };
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes, gp::SerializeArrays(arrays));
  return kernels::WriteFileAtomically(absl::StrFormat("%s/%06d.npz", directory, frame.index),
                                      bytes);
}

// Frames that are still to come; -1 where unknown.
int64_t ExpectedFrames(const vision::FrameSource& source, const vision::PipelineOptions& pipeline) {
  int64_t end = source.expected_frame_count();
  if (pipeline.end_frame >= 0) {
    end = end < 0 ? pipeline.end_frame : std::min(end, pipeline.end_frame);
  }
  if (end < 0) return -1;
  const int64_t frames = std::max<int64_t>(end - pipeline.first_frame, 0);
  return (frames + pipeline.frame_step - 1) / pipeline.frame_step;
}

// A frame that could not be read keeps its index: its file will be unreadable, too.
absl::Status Record(const std::string& directory, const vision::SegmentedFrame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(directory));
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File(RunFolder::kRecorded)));
  std::string png;
  if (!frame.damage.has_value()) {
    EGOSIEVE_ASSIGN_OR_RETURN(png, EncodePng(frame.frame.image));
  }
  return WriteFileAtomically(folder.FrameFile(RunFolder::kRecorded, frame.index, ".png"), png);
}

void Tell(const SegmentCall& call, const DriveWriter::Counts& counts, double seconds,
          const std::string& text) {
  call.result.Tell("segment",
                   {{"run", call.directory},
                    {"frames_answered", counts.answered},
                    {"frames_learnt", counts.learnt},
                    {"frames_failed", counts.failed},
                    {"pairs_far_apart", counts.baselines.far_apart()},
                    {"frames_unreliable", counts.doubtful.count()},
                    {"seconds", seconds}},
                   text);
}

// The same for a run that has just ended and for one that was finished before.
ExitCode Judge(const DriveWriter::Counts& counts, const std::string& warning) {
  const RunVerdict verdict = JudgeRun(counts, warning);
  for (const std::string& text : verdict.warnings) Warn(text);
  return verdict.code;
}

absl::StatusOr<ExitCode> EndRun(const SegmentCall& call,
                                const absl::StatusOr<vision::PipelineSummary>& summary,
                                const DriveInput& input, double seconds, DriveWriter& writer) {
  const bool is_interrupted = IsInterruption(summary.status());
  if (!summary.ok() && !is_interrupted) {
    // This error is returned; if run.json cannot be written, it keeps saying "running".
    writer.Finish("failed", std::string(summary.status().message()), seconds).IgnoreError();
    return summary.status();
  }
  // A stream ends when its reader stops.
  const bool is_cut_short = is_interrupted || (summary->stopped && !input.is_live);
  EGOSIEVE_RETURN_IF_ERROR(writer.Finish(is_cut_short ? "interrupted" : "done", "", seconds));
  const DriveWriter::Counts& counts = writer.counts();
  std::string text =
      absl::StrFormat("%d frames answered, %d learnt from, in %s: %s\n", counts.answered,
                      counts.learnt, DescribeDuration(seconds), call.directory);
  EGOSIEVE_ASSIGN_OR_RETURN(const ShotList shots, ReadShots(call.directory));
  const std::string cuts = DescribeCuts(shots);
  if (!cuts.empty()) absl::StrAppend(&text, cuts, "\n");
  if (counts.doubtful.count() > 0) absl::StrAppend(&text, counts.doubtful.Sentence(), "\n");
  Tell(call, counts, seconds, text);
  if (is_cut_short) {
    return absl::CancelledError(absl::StrCat("interrupted; the ", counts.answered + counts.failed,
                                             " frames in ", call.directory,
                                             " are whole, --resume goes on"));
  }
  return Judge(counts, summary->warning);
}

// `created`: absent for the run that --resume found.
absl::StatusOr<ExitCode> SegmentOnline(const SegmentCall& call, const DriveInput& input,
                                       const OpenedDevice& device,
                                       const std::optional<RunFolder>& created, int threads) {
  const vision::OnlineSegmenterOptions& options = call.settings.segmenter;
  const std::string& features = call.settings.features;
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<vision::OnlineSegmenter> segmenter,
                            vision::OnlineSegmenter::Create(device.context, options));
  const RunDescription description = DescribeRun(call, input, device.info);
  RunBeginning beginning;
  if (created) {
    beginning.first_frame = call.settings.schedule.first_frame();
    EGOSIEVE_ASSIGN_OR_RETURN(beginning.writer,
                              DriveWriter::Open(*created, description, {}, description.device));
    EGOSIEVE_RETURN_IF_ERROR(call.camera.Write(call.directory));
  } else {
    EGOSIEVE_ASSIGN_OR_RETURN(beginning, ContinueRun(call, description, *input.frames, *segmenter));
  }
  if (!beginning.writer) {
    Tell(call, *beginning.counts, 0.0,
         absl::StrCat(call.directory, " holds the whole run already\n"));
    return Judge(*beginning.counts, beginning.warning);
  }
  const vision::PipelineOptions pipeline =
      call.settings.schedule.MakePipeline(threads, beginning.first_frame);
  if (!features.empty()) EGOSIEVE_RETURN_IF_ERROR(CreateFolder(features));
  DriveWriter& writer = *beginning.writer;
  Progress progress("segment", call.progress, ExpectedFrames(*input.frames, pipeline));
  std::optional<double> first_seconds;  // of the drive
  const auto write = [&](const vision::SegmentedFrame& frame) {
    if (!features.empty()) {
      EGOSIEVE_RETURN_IF_ERROR(DumpFeatures(frame, options, features));
    }
    if (call.record) EGOSIEVE_RETURN_IF_ERROR(Record(call.directory, frame));
    EGOSIEVE_RETURN_IF_ERROR(writer.Write(frame, input.frames->image_name(frame.index)));
    const FrameLine& line = writer.last_line();
    if (!first_seconds) first_seconds = line.time_seconds;
    progress.Advance(
        {{"times real time", (line.time_seconds - *first_seconds) / progress.Seconds()},
         {"model size", static_cast<double>(line.model_size)},
         {"dynamic share", line.dynamic_share}});
    if (!call.watch) return absl::OkStatus();
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string news, call.watch(line));
    if (!news.empty()) progress.Say(news);
    return absl::OkStatus();
  };
  absl::StatusOr<vision::PipelineSummary> summary =
      vision::RunPipeline(*input.frames, *segmenter, pipeline, InterruptionRequested, write);
  if (summary.ok()) {
    const absl::Status learnt =
        call.camera.WriteLearnt(call.directory, input, segmenter->labeller().learnt_camera());
    if (!learnt.ok()) summary = learnt;
  }
  progress.Finish();
  return EndRun(call, summary, input, progress.Seconds(), writer);
}

class SegmentCommand : public Command {
 public:
  std::string name() const override { return "segment"; }
  std::string summary() const override {
    return "Segments a drive: maps of what moves by itself, and a line of the log per frame.";
  }
  std::string example() const override {
    return "egosieve segment drive.mp4 --out=out/drive\n"
           "egosieve segment drive.mp4 -o out/no_prior --set location_prior=0\n"
           "egosieve segment drive.mp4 --max-frames=100\n"
           "egosieve segment 'frames/*.png' --out=out/frames --stride=3 --profile=paper";
  }
  void AddFlags(CLI::App& app) override { call_.AddFlags(app); }
  absl::StatusOr<ExitCode> Run() override { return RunSegment(call_); }

 private:
  SegmentCall call_;
};

}  // namespace

absl::StatusOr<ExitCode> RunSegment(SegmentCall& call) {
  const int threads = call.threads.Apply();
  EGOSIEVE_RETURN_IF_ERROR(call.Resolve());
  SegmentSettings& settings = call.settings;
  EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, call.OpenInput());
  if (input.is_live) settings.segmenter.ahead_frames = 0;
  EGOSIEVE_RETURN_IF_ERROR(call.camera.Read(settings.camera, input));
  EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, call.device.Open());
  EGOSIEVE_RETURN_IF_ERROR(call.CheckFolder(input));
  if (InterruptionRequested()) {
    return absl::CancelledError("interrupted; nothing was written");
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<FolderLock> lock,
                            RunFolder::TakeOrMake(call.directory));
  const int64_t from = settings.schedule.first_frame(), step = settings.schedule.frame_step();
  // Before the folder is replaced: interrupting the first pass keeps the former run.
  const int64_t end = settings.schedule.MakePipeline(threads, from).end_frame;
  EGOSIEVE_RETURN_IF_ERROR(call.camera.Find(input, from, end, call.resume, call.directory,
                                            call.progress, settings.segmenter.labeller));
  if (step > 1) {
    input.frames = std::make_unique<vision::SteppedFrames>(std::move(input.frames), from, step);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<RunFolder> created, CreateUnlessResumed(call));
  return SegmentOnline(call, input, device, created, threads);
}

std::unique_ptr<Command> MakeSegmentCommand() { return std::make_unique<SegmentCommand>(); }

}  // namespace egosieve::tools
