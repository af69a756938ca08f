#include "tools/segment/segment_command.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <string>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/version.h"
#include "tools/segment/drive_input.h"
#include "tools/segment/drive_writer.h"
#include "tools/segment/segment_flags.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {
namespace {

// A header's count may be a guess: only a video that lacks more than this share was cut short.
constexpr double kMissingShare = 0.1;

void Warn(const std::string& message) {
  std::cerr << ErrorLine(absl::StrCat("warning: ", message)) << "\n";
}

class SegmentCommand : public Command {
 public:
  std::string name() const override { return "segment"; }
  std::string summary() const override {
    return "Segments a drive: maps of what moves by itself, with the account of every frame.";
  }
  std::string example() const override {
    return "egosieve segment drive.mp4 --out=out/drive\n"
           "egosieve segment 'frames/*.png' --out=out/frames --stride=3 --profile=paper";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("INPUT", input_, "A video, a folder of images, or a glob of images")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--out", directory_, "The run folder to write")->required()->type_name("DIR");
    app.add_flag("--overwrite", overwrite_, "Replace the run that the folder holds");
    flags_.AddFlags(app);
    range_.AddFlags(app);
    app.add_option("--max_frames", max_frames_, "Frames to segment at most; 0: no limit")
        ->check(AtLeast<int64_t>(0))
        ->type_name("FRAMES");
    app.add_option(
           "--threads", threads_,
           "Threads of the front end, beside the device's; with 1 the stages do not overlap "
           "either; 0: the machine's cores. The output is the same")
        ->check(Between(0, 256))
        ->type_name("NUMBER");
    device_.AddFlag(app);
    progress_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_RETURN_IF_ERROR(range_.Validate());
    const int threads =
        threads_ > 0 ? threads_
                     : std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 256);
    const vision::OnlineSegmenterOptions options = flags_.MakeOptions(threads);
    EGOSIEVE_RETURN_IF_ERROR(options.Validate());
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenDriveInput(input_, range_.from));
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, device_.Open());
    EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<vision::OnlineSegmenter> segmenter,
                              vision::OnlineSegmenter::Create(device.context, options));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Create(directory_, overwrite_));
    EGOSIEVE_ASSIGN_OR_RETURN(DriveWriter writer,
                              DriveWriter::Start(folder, Describe(input, device.info, options)));

    const vision::PipelineOptions pipeline = MakePipeline(threads);
    CatchInterruptions();
    Progress progress("segment", progress_, ExpectedFrames(*input.frames, pipeline));
    const auto start = std::chrono::steady_clock::now();
    const absl::StatusOr<vision::PipelineSummary> summary = vision::RunPipeline(
        *input.frames, *segmenter, pipeline, InterruptionRequested,
        [&](const vision::SegmentedFrame& frame) {
          EGOSIEVE_RETURN_IF_ERROR(writer.Write(frame));
          const FrameLine& line = writer.last_line();
          progress.Advance({{"model size", static_cast<double>(line.model_size)},
                            {"dynamic share", line.dynamic_share}});
          return absl::OkStatus();
        });
    progress.Finish();
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return End(summary, input, seconds, writer);
  }

 private:
  RunDescription Describe(const DriveInput& input, const kernels::DeviceInfo& device,
                          const vision::OnlineSegmenterOptions& options) const {
    RunDescription description;
    description.version = kVersion;
    description.flags = DescribeOptions(options);
    description.flags["from"] = absl::StrCat(range_.from);
    description.device = DescribeDevice(device);
    description.seed = flags_.seed();
    description.input = input.description;
    description.grid = {input.width_pixels, input.height_pixels, options.stride_pixels};
    description.started_utc = UtcNow();
    return description;
  }

  vision::PipelineOptions MakePipeline(int threads) const {
    vision::PipelineOptions pipeline;
    pipeline.overlap = threads > 1;
    pipeline.first_frame = range_.from;
    pipeline.end_frame = range_.to >= 0 ? range_.to + 1 : -1;
    if (max_frames_ > 0) {
      const int64_t end = range_.from + max_frames_;
      pipeline.end_frame = pipeline.end_frame < 0 ? end : std::min(pipeline.end_frame, end);
    }
    return pipeline;
  }

  static int64_t ExpectedFrames(const vision::FrameSource& source,
                                const vision::PipelineOptions& pipeline) {
    int64_t end = source.expected_frame_count();
    if (pipeline.end_frame >= 0) {
      end = end < 0 ? pipeline.end_frame : std::min(end, pipeline.end_frame);
    }
    return end < 0 ? -1 : std::max<int64_t>(end - pipeline.first_frame, 0);
  }

  absl::StatusOr<ExitCode> End(const absl::StatusOr<vision::PipelineSummary>& summary,
                               const DriveInput& input, double seconds, DriveWriter& writer) const {
    if (!summary.ok()) {
      // The error is what matters; a run.json that cannot be written says "running" for ever.
      writer.Finish("failed", std::string(summary.status().message()), seconds).IgnoreError();
      return summary.status();
    }
    EGOSIEVE_RETURN_IF_ERROR(writer.Finish(summary->stopped ? "interrupted" : "done", "", seconds));
    const DriveWriter::Counts& counts = writer.counts();
    std::cout << absl::StrFormat("%d frames answered, %d learnt from, in %s: %s\n", counts.answered,
                                 counts.learnt, DescribeDuration(seconds), directory_);
    if (summary->stopped) {
      return absl::CancelledError(absl::StrCat("interrupted; the ", counts.answered + counts.failed,
                                               " frames in ", directory_, " are whole"));
    }
    return Judge(counts, *summary, input);
  }

  ExitCode Judge(const DriveWriter::Counts& counts, const vision::PipelineSummary& summary,
                 const DriveInput& input) const {
    if (counts.other_sizes > 0) {
      Warn(absl::StrCat(counts.other_sizes,
                        " frames are of another size than the first; their maps have their size"));
    }
    if (counts.answered > 0 && counts.learnt == 0) {
      Warn(absl::StrCat("nothing was learnt, so every map is the prior: ", counts.last_not_learnt,
                        "; give frames of a moving camera, two at least"));
    }
    bool failed = counts.failed > 0;
    if (counts.failed > 0) {
      Warn(absl::StrCat(counts.failed,
                        " frames have no map, the first because: ", counts.first_failure));
    }
    if (!summary.warning.empty()) {
      Warn(summary.warning);
      const double expected = static_cast<double>(input.frames->expected_frame_count());
      failed |= static_cast<double>(input.frames->next_index()) < (1.0 - kMissingShare) * expected;
    }
    return failed ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

  std::string input_, directory_;
  bool overwrite_ = false;
  SegmentFlags flags_;
  FrameRange range_;
  int64_t max_frames_ = 0;
  int threads_ = 0;
  DeviceFlag device_;
  ProgressFlag progress_;
};

}  // namespace

std::unique_ptr<Command> MakeSegmentCommand() { return std::make_unique<SegmentCommand>(); }

}  // namespace egosieve::tools
