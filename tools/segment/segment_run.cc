#include "tools/segment/segment_run.h"

#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/interruption.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/map_image.h"
#include "tools/segment/feature_dump.h"
#include "tools/segment/run_beginning.h"
#include "tools/segment/run_verdict.h"
#include "vision/frame/stepped_frames.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {
namespace {

// Gives the drive's frames to a sink.
using FrameRun =
    std::function<absl::StatusOr<vision::PipelineSummary>(const vision::SegmentedFrameSink& sink)>;

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
                      counts.learnt, DescribeDuration(seconds), call.directory);
  if (counts.doubtful.count() > 0) absl::StrAppend(&text, counts.doubtful.Sentence(), "\n");
  Tell(call, counts, seconds, text);
  if (is_cut_short) {
    return absl::CancelledError(absl::StrCat("interrupted; the ", counts.answered + counts.failed,
                                             " frames in ", call.directory,
                                             " are whole, --resume goes on"));
  }
  return Judge(counts, summary->warning);
}

// Writes the frames that `run` gives to its sink, and how the run ended.
absl::StatusOr<ExitCode> WriteAll(const SegmentCall& call, const DriveInput& input,
                                  const vision::PipelineOptions& pipeline, DriveWriter& writer,
                                  const FrameRun& run) {
  Progress progress("segment", call.progress, ExpectedFrames(*input.frames, pipeline));
  std::optional<double> first_seconds;  // of the drive
  const absl::StatusOr<vision::PipelineSummary> summary =
      run([&](const vision::SegmentedFrame& frame) {
        if (call.record) EGOSIEVE_RETURN_IF_ERROR(Record(call.directory, frame));
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
  return EndRun(call, summary, input, progress.Seconds(), writer);
}

// `created`: absent for the run that --resume found.
absl::StatusOr<ExitCode> SegmentOnline(const SegmentCall& call, const DriveInput& input,
                                       const OpenedDevice& device,
                                       const vision::OnlineSegmenterOptions& options,
                                       const std::optional<RunFolder>& created, int threads) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<vision::OnlineSegmenter> segmenter,
                            vision::OnlineSegmenter::Create(device.context, options));
  const RunDescription description = DescribeRun(call, input, device.info, options);
  RunBeginning beginning;
  if (created) {
    beginning.first_frame = call.schedule.first_frame();
    EGOSIEVE_ASSIGN_OR_RETURN(beginning.writer, StartRun(call, *created, description));
  } else {
    EGOSIEVE_ASSIGN_OR_RETURN(beginning, ContinueRun(call, description, *input.frames, *segmenter));
  }
  if (!beginning.writer) {
    Tell(call, *beginning.counts, 0.0,
         absl::StrCat(call.directory, " holds the whole run already\n"));
    return Judge(*beginning.counts, beginning.warning);
  }
  const vision::PipelineOptions pipeline =
      call.schedule.MakePipeline(threads, beginning.first_frame);
  if (!call.features.empty()) EGOSIEVE_RETURN_IF_ERROR(CreateFolder(call.features));
  return WriteAll(
      call, input, pipeline, *beginning.writer,
      [&](const vision::SegmentedFrameSink& sink) -> absl::StatusOr<vision::PipelineSummary> {
        const auto dump_and_sink = [&](const vision::SegmentedFrame& frame) {
          if (!call.features.empty()) {
            EGOSIEVE_RETURN_IF_ERROR(DumpFeatures(frame, *device.context, options, call.features));
          }
          return sink(frame);
        };
        EGOSIEVE_ASSIGN_OR_RETURN(vision::PipelineSummary summary,
                                  vision::RunPipeline(*input.frames, *segmenter, pipeline,
                                                      InterruptionRequested, dump_and_sink));
        EGOSIEVE_RETURN_IF_ERROR(
            call.camera.WriteLearnt(call.directory, input, segmenter->learnt_camera()));
        return summary;
      });
}

// The frames that are segmented in `lag` seconds, to the nearest.
absl::StatusOr<int> FramesOfLag(double lag, const DriveInput& input,
                                const ScheduleFlags& schedule) {
  EGOSIEVE_ASSIGN_OR_RETURN(const double seconds,
                            SecondsPerFrame(*input.frames, schedule.first_frame()));
  if (!(seconds > 0.0)) return 0;
  const double frames = std::round(lag / (seconds * static_cast<double>(schedule.frame_step())));
  if (frames > kMostFramesAhead) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--lag=%g is %.0f frames here; at most %d can be used", lag, frames, kMostFramesAhead));
  }
  return static_cast<int>(frames);
}

}  // namespace

absl::StatusOr<ExitCode> RunSegment(SegmentCall& call) {
  EGOSIEVE_RETURN_IF_ERROR(call.Validate());
  const int threads = call.threads.Apply();
  EGOSIEVE_ASSIGN_OR_RETURN(vision::OnlineSegmenterOptions options, call.MakeOptions(threads));
  EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, call.OpenInput());
  if (input.is_live) {
    options.ahead_frames = 0;
  } else if (const std::optional<double> lag = call.segmenter.lag_seconds()) {
    EGOSIEVE_ASSIGN_OR_RETURN(options.ahead_frames, FramesOfLag(*lag, input, call.schedule));
  }
  EGOSIEVE_RETURN_IF_ERROR(call.camera.Read(input));
  EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, call.device.Open());
  EGOSIEVE_RETURN_IF_ERROR(call.CheckFolder(input));
  if (InterruptionRequested()) {
    return absl::CancelledError("interrupted; nothing was written");
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<FolderLock> lock,
                            RunFolder::TakeOrMake(call.directory));
  const int64_t from = call.schedule.first_frame(), step = call.schedule.frame_step();
  // Before the folder is replaced: interrupting the first pass keeps the former run.
  EGOSIEVE_RETURN_IF_ERROR(
      call.camera.Find(input, from, call.resume, call.directory, options.labeller));
  if (step > 1) {
    input.frames = std::make_unique<vision::SteppedFrames>(std::move(input.frames), from, step);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<RunFolder> created, CreateUnlessResumed(call));
  return SegmentOnline(call, input, device, options, created, threads);
}

}  // namespace egosieve::tools
