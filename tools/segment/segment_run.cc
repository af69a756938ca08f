#include "tools/segment/segment_run.h"

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
                                       const std::optional<RunFolder>& created, int threads) {
  const vision::OnlineSegmenterOptions& options = call.settings.segmenter;
  const std::string& features = call.settings.features;
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<vision::OnlineSegmenter> segmenter,
                            vision::OnlineSegmenter::Create(device.context, options));
  const RunDescription description = DescribeRun(call, input, device.info);
  RunBeginning beginning;
  if (created) {
    beginning.first_frame = call.settings.schedule.first_frame();
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
      call.settings.schedule.MakePipeline(threads, beginning.first_frame);
  if (!features.empty()) EGOSIEVE_RETURN_IF_ERROR(CreateFolder(features));
  return WriteAll(
      call, input, pipeline, *beginning.writer,
      [&](const vision::SegmentedFrameSink& sink) -> absl::StatusOr<vision::PipelineSummary> {
        const auto dump_and_sink = [&](const vision::SegmentedFrame& frame) {
          if (!features.empty()) {
            EGOSIEVE_RETURN_IF_ERROR(DumpFeatures(frame, *device.context, options, features));
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

}  // namespace

absl::StatusOr<ExitCode> RunSegment(SegmentCall& call) {
  const int threads = call.threads.Apply();
  EGOSIEVE_RETURN_IF_ERROR(call.Resolve(threads));
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
  EGOSIEVE_RETURN_IF_ERROR(call.camera.Find(input, from, call.resume, call.directory, call.progress,
                                            settings.segmenter.labeller));
  if (step > 1) {
    input.frames = std::make_unique<vision::SteppedFrames>(std::move(input.frames), from, step);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<RunFolder> created, CreateUnlessResumed(call));
  return SegmentOnline(call, input, device, created, threads);
}

}  // namespace egosieve::tools
