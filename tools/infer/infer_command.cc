#include "tools/infer/infer_command.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/threads_flag.h"
#include "tools/infer/map_book.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/segment/drive_input.h"
#include "tools/segment/drive_writer.h"
#include "tools/segment/resume.h"
#include "tools/segment/segment_flags.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {
namespace {

// A number that `segment` wrote into run.json.
absl::StatusOr<int64_t> NumberOf(const RunDescription& description, const std::string& flag) {
  const auto found = description.flags.find(flag);
  int64_t number = 0;
  if (found == description.flags.end() || !absl::SimpleAtoi(found->second, &number)) {
    return absl::DataLossError(
        absl::StrCat("run.json tells no --", flag, "; segment the drive again"));
  }
  return number;
}

class InferCommand : public Command {
 public:
  std::string name() const override { return "infer"; }
  std::string summary() const override {
    return "Makes the maps that segment --learn_only or --every left out.";
  }
  std::string example() const override {
    return "egosieve infer out/drive\n"
           "egosieve infer out/drive --from=1000 --to=1999 --device=gpu\n"
           "egosieve infer out/drive --stride=1 --every=10 --out=out/fine";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", directory_, "The run folder, which keeps the model of every frame")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--out", out_,
                   "The run folder to write; none: DIR itself, in which several programs may work "
                   "on different frames at the same time")
        ->type_name("DIR");
    app.add_flag("--overwrite", overwrite_,
                 "Replace the run that --out holds; without --out, make maps again that are there");
    app.add_option("--input", input_, "Where the run's input is now, if it was moved")
        ->type_name("PATH");
    range_.AddFlags(app);
    app.add_option("--every", every_, "Makes each N-th map only, from the run's first frame on")
        ->check(AtLeast<int64_t>(1))
        ->type_name("N");
    app.add_option("--stride", stride_,
                   "Pixels between neighbouring grid pixels; 0: the run's; others need --out")
        ->check(Between(0, 1000))
        ->type_name("PIXELS");
    threads_.AddFlag(app);
    device_.AddFlag(app);
    progress_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_RETURN_IF_ERROR(range_.Validate());
    EGOSIEVE_ASSIGN_OR_RETURN(Work work, OpenRun());
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenInput(work));
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, device_.Open());
    work.device = DescribeDevice(device.info);
    EGOSIEVE_ASSIGN_OR_RETURN(MapBook book, OpenBook(work));
    const std::vector<int64_t> wanted = WantedFrames(work, book);
    if (wanted.empty()) {
      std::cout << work.target << " holds these maps already\n";
      return ExitCode::kDone;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<vision::OnlineSegmenter> segmenter,
                              vision::OnlineSegmenter::Create(device.context, work.options));
    EGOSIEVE_RETURN_IF_ERROR(ReplayUntil(work, wanted.front(), *segmenter));
    return Infer(work, wanted, *input.frames, *segmenter, book);
  }

 private:
  struct Work {
    std::optional<RunFolder> run;
    RunDescription description;
    std::vector<FrameLine> lines;
    vision::OnlineSegmenterOptions options;
    int64_t run_from = 0;
    int64_t checkpoint_every = 0;
    std::string target;  // folder that gets the maps
    std::string device;  // that makes them
  };

  absl::StatusOr<Work> OpenRun() const {
    Work work;
    EGOSIEVE_ASSIGN_OR_RETURN(work.run, RunFolder::Open(directory_));
    EGOSIEVE_ASSIGN_OR_RETURN(work.description, work.run->ReadDescription());
    if (!work.description.maps_from.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat(directory_, " holds maps alone; make more: egosieve infer ",
                       work.description.maps_from, " --out=", directory_));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(work.run_from, NumberOf(work.description, "from"));
    EGOSIEVE_ASSIGN_OR_RETURN(work.checkpoint_every,
                              NumberOf(work.description, "checkpoint_every"));
    EGOSIEVE_ASSIGN_OR_RETURN(const int64_t every, NumberOf(work.description, "every"));
    if (every == 1 && work.description.flags["learn_only"] != "yes") {
      return absl::FailedPreconditionError(
          absl::StrCat("the run in ", directory_,
                       " has all its maps and kept no models to make others from; segment the "
                       "drive with --learn_only for that"));
    }
    if (!out_.empty() && AbsolutePath(out_) == AbsolutePath(directory_)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--out=", out_, " is the run itself; leave --out away to make its maps there"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(work.options, ReadInferenceOptions(work.description.flags));
    if (stride_ > 0 && stride_ != work.options.stride_pixels && out_.empty()) {
      return absl::InvalidArgumentError(absl::StrCat("--stride=", stride_, " is not the run's ",
                                                     work.options.stride_pixels,
                                                     "; give the maps a folder with --out"));
    }
    if (stride_ > 0) work.options.stride_pixels = stride_;
    EGOSIEVE_RETURN_IF_ERROR(ChooseLines(*work.run, range_).status());
    EGOSIEVE_ASSIGN_OR_RETURN(work.lines, work.run->ReadLines());
    work.target = out_.empty() ? directory_ : out_;
    return work;
  }

  absl::StatusOr<DriveInput> OpenInput(const Work& work) const {
    const std::string path = input_.empty() ? work.description.input.path : input_;
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenDriveInput(path, work.run_from));
    if (input.description.fingerprint != work.description.input.fingerprint) {
      return absl::FailedPreconditionError(absl::StrCat(path, " is not the input of the run in ",
                                                        directory_, "; give that with --input"));
    }
    return input;
  }

  // The first frame of the range; where that cannot be read, the one before it whose map it has.
  int64_t FirstFrame(const Work& work) const {
    int64_t first = range_.from;
    for (const FrameLine& line : work.lines) {
      const bool failed = line.outcome == FrameLine::Outcome::kFailed;
      if ((line.index - work.run_from) % every_ != 0) continue;
      if (line.index < range_.from && !failed) first = line.index;
      if (line.index >= range_.from) return failed ? first : range_.from;
    }
    return range_.from;
  }

  // With --out, a folder with this range's lines, that have no maps yet; or the one that an earlier
  // call has begun.
  absl::StatusOr<MapBook> OpenBook(const Work& work) const {
    if (out_.empty()) return MapBook::Open(*work.run, work.description, {}, work.device);
    RunDescription description = work.description;
    description.device = work.device;
    description.maps_from = AbsolutePath(directory_);
    description.grid.stride = work.options.stride_pixels;
    description.flags["stride"] = absl::StrCat(work.options.stride_pixels);
    description.flags["learn_only"] = "no";
    description.flags["every"] = "1";
    description.ended = "running";
    description.ended_message.clear();
    description.seconds = 0.0;
    description.started_utc = UtcNow();
    description.finished_utc.clear();
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, OpenTarget(description));
    std::vector<FrameLine> lines;
    const FrameRange range{FirstFrame(work), range_.to};
    for (FrameLine line : work.lines) {
      if (!range.Contains(line.index)) continue;
      line.width_pixels = line.height_pixels = 0;
      line.dynamic_share = 0.0;
      line.map_device.clear();
      lines.push_back(std::move(line));
    }
    return MapBook::Open(folder, description, lines, work.device);
  }

  // The folder of --out, which holds nothing or maps of the same making.
  absl::StatusOr<RunFolder> OpenTarget(const RunDescription& description) const {
    absl::StatusOr<RunFolder> folder = RunFolder::Open(out_);
    if (folder.ok() && !overwrite_) {
      EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription before, folder->ReadDescription());
      const std::string difference = DescribeDifference(before, description);
      if (difference.empty()) return folder;
      return absl::AlreadyExistsError(
          absl::StrCat("the folder ", out_, " holds another run: ", difference,
                       "; choose another for --out, or add --overwrite"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(folder, RunFolder::Create(out_, overwrite_));
    EGOSIEVE_RETURN_IF_ERROR(folder->WriteDescription(description));
    return folder;
  }

  // Of the range, what is due and not there.
  std::vector<int64_t> WantedFrames(const Work& work, const MapBook& book) const {
    const FrameRange range{FirstFrame(work), range_.to};
    std::vector<int64_t> wanted;
    for (const auto& [index, line] : book.lines()) {
      if (!range.Contains(index) || (index - work.run_from) % every_ != 0) continue;
      const bool again = overwrite_ && out_.empty() && range_.Contains(index);
      if (!line.has_map() || again) wanted.push_back(index);
    }
    return wanted;
  }

  // The model as it was before frame `first`, from the checkpoint nearest to it.
  absl::Status ReplayUntil(const Work& work, int64_t first,
                           vision::OnlineSegmenter& segmenter) const {
    int64_t next = work.run_from;
    if (const auto checkpoint = FindCheckpoint(*work.run, first - 1); checkpoint.has_value()) {
      EGOSIEVE_RETURN_IF_ERROR(segmenter.Restore(checkpoint->bytes, {}));
      next = checkpoint->next_frame;
    }
    for (const FrameLine& line : work.lines) {
      if (line.index < next || line.index >= first) continue;
      EGOSIEVE_ASSIGN_OR_RETURN(const std::string step, StepOf(work, line));
      if (!step.empty()) EGOSIEVE_RETURN_IF_ERROR(segmenter.Replay(step));
      if (work.checkpoint_every > 0 && (line.index + 1) % work.checkpoint_every == 0) {
        EGOSIEVE_RETURN_IF_ERROR(segmenter.Checkpoint().status());
      }
    }
    return absl::OkStatus();
  }

  static absl::StatusOr<std::string> StepOf(const Work& work, const FrameLine& line) {
    if (line.outcome == FrameLine::Outcome::kFailed) return std::string();
    absl::StatusOr<std::string> step = ReadStep(*work.run, line.index);
    if (step.ok()) return step;
    return absl::DataLossError(
        absl::StrCat("the model of frame ", line.index, " is missing: ", step.status().message()));
  }

  absl::StatusOr<ExitCode> Infer(const Work& work, const std::vector<int64_t>& wanted,
                                 vision::FrameSource& frames, vision::OnlineSegmenter& segmenter,
                                 MapBook& book) const {
    const auto is_wanted = [&wanted](int64_t index) {
      return std::binary_search(wanted.begin(), wanted.end(), index);
    };
    vision::PipelineOptions pipeline;
    pipeline.overlap = threads_.Apply() > 1;
    pipeline.first_frame = wanted.front();
    pipeline.end_frame = wanted.back() + 1;
    pipeline.checkpoint_interval = work.checkpoint_every;
    pipeline.wants_map = is_wanted;
    pipeline.recorded_step = [&](int64_t index) -> absl::StatusOr<std::string> {
      const auto line = std::lower_bound(
          work.lines.begin(), work.lines.end(), index,
          [](const FrameLine& candidate, int64_t target) { return candidate.index < target; });
      if (line == work.lines.end() || line->index != index) return std::string();
      return StepOf(work, *line);
    };
    CatchInterruptions();
    Progress progress("infer", progress_, static_cast<int64_t>(wanted.size()));
    const auto start = std::chrono::steady_clock::now();
    int64_t made = 0;
    bool failed = false;
    const absl::StatusOr<vision::PipelineSummary> summary =
        vision::RunPipeline(frames, segmenter, pipeline, InterruptionRequested,
                            [&](const vision::SegmentedFrame& frame) {
                              if (!is_wanted(frame.index)) return absl::OkStatus();
                              EGOSIEVE_RETURN_IF_ERROR(book.Write(frame));
                              ++made;
                              failed |= frame.damage.has_value();
                              progress.Advance();
                              return absl::OkStatus();
                            });
    progress.Finish();
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    // What was made is entered even after an error, which is what is told.
    const absl::Status entered = book.Enter();
    const absl::Status told = TellEnd(summary, seconds, book);
    EGOSIEVE_RETURN_IF_ERROR(summary.status());
    EGOSIEVE_RETURN_IF_ERROR(entered);
    EGOSIEVE_RETURN_IF_ERROR(told);
    std::cout << absl::StrFormat("%d maps in %s on %s: %s\n", made, DescribeDuration(seconds),
                                 work.device, work.target);
    if (summary->stopped) {
      return absl::CancelledError(absl::StrCat("interrupted; the ", made, " maps made are whole, ",
                                               "the same command goes on"));
    }
    return failed ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

  // run.json of --out; that of a run is the run's.
  absl::Status TellEnd(const absl::StatusOr<vision::PipelineSummary>& summary, double seconds,
                       const MapBook& book) const {
    if (out_.empty()) return absl::OkStatus();
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(out_));
    EGOSIEVE_ASSIGN_OR_RETURN(RunDescription description, folder.ReadDescription());
    description.ended = !summary.ok() ? "failed" : summary->stopped ? "interrupted" : "done";
    description.ended_message = std::string(summary.status().message());
    description.frames_answered = description.frames_learnt = description.frames_failed = 0;
    for (const auto& [index, line] : book.lines()) {
      const bool failed = line.outcome == FrameLine::Outcome::kFailed;
      description.frames_failed += failed;
      description.frames_answered += !failed && line.has_map();
      description.frames_learnt += line.outcome == FrameLine::Outcome::kLearnt;
    }
    description.seconds += seconds;
    description.finished_utc = UtcNow();
    return folder.WriteDescription(description);
  }

  std::string directory_, out_, input_;
  bool overwrite_ = false;
  FrameRange range_;
  int64_t every_ = 1;
  int stride_ = 0;
  ThreadsFlag threads_;
  DeviceFlag device_;
  ProgressFlag progress_;
};

}  // namespace

std::unique_ptr<Command> MakeInferCommand() { return std::make_unique<InferCommand>(); }

}  // namespace egosieve::tools
