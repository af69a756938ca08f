#include "tools/infer/infer_command.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/threads_flag.h"
#include "tools/infer/map_book.h"
#include "tools/infer/map_target.h"
#include "tools/infer/model_replay.h"
#include "tools/infer/shard.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/segment/drive_input.h"
#include "tools/segment/segment_flags.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(1000);  // for a run that is still being written
constexpr auto kShortPoll = std::chrono::milliseconds(50);

// A number that `segment` wrote to run.json.
absl::StatusOr<int64_t> NumberOf(const RunDescription& description, const std::string& flag) {
  const auto found = description.flags.find(flag);
  int64_t number = 0;
  if (found == description.flags.end() || !absl::SimpleAtoi(found->second, &number)) {
    return absl::DataLossError(
        absl::StrCat("run.json has no --", flag, "; segment the drive again"));
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
           "egosieve infer out/drive --stride=1 --every=10 --out=out/fine\n"
           "egosieve infer out/drive --shard=1/2 & egosieve infer out/drive --shard=2/2";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", target_.run, "The run folder, which keeps the model of every frame")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--out", target_.out,
                   "The run folder to write; none: DIR itself, in which several programs may work "
                   "on different frames at the same time")
        ->type_name("DIR");
    app.add_flag("--overwrite", target_.overwrite,
                 "Replace the run that --out holds; without --out, make existing maps again");
    app.add_option("--input", input_, "Where the run's input is now, if it was moved")
        ->type_name("PATH");
    range_.AddFlags(app);
    app.add_option("--every", every_, "Makes each N-th map only, from the run's first frame on")
        ->check(AtLeast<int64_t>(1))
        ->type_name("N");
    app.add_option("--shard", shard_,
                   "Makes the K-th of N shares, from 1 on; checkpoints bound the pieces that are "
                   "dealt out in turn")
        ->type_name("K/N");
    app.add_option("--stride", stride_,
                   "Pixels between neighbouring grid pixels; 0: the run's; others need --out")
        ->check(Between(0, 1000))
        ->type_name("PIXELS");
    threads_.AddFlag(app);
    device_.AddFlag(app);
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_RETURN_IF_ERROR(range_.Validate());
    EGOSIEVE_ASSIGN_OR_RETURN(Work work, OpenRun());
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenInput(work));
    EGOSIEVE_RETURN_IF_ERROR(target_.CheckApartFrom(*input.frames));
    threads_.Apply();
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, device_.Open());
    work.device = DescribeDevice(device.info);
    if (InterruptionRequested()) {
      return absl::CancelledError("interrupted; nothing was written");
    }
    // Keep models and maps from being removed meanwhile.
    EGOSIEVE_ASSIGN_OR_RETURN(const FolderLock reading, FolderLock::Use(target_.run));
    EGOSIEVE_ASSIGN_OR_RETURN(MapBook book, target_.Open(*work.run, work.description,
                                                         work.options.stride_pixels, work.device));
    EGOSIEVE_ASSIGN_OR_RETURN(const FolderLock writing, FolderLock::Use(target_.path()));
    EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<vision::OnlineSegmenter> segmenter,
                              vision::OnlineSegmenter::Create(device.context, work.options));
    work.models.emplace(*work.run, work.checkpoint_every, std::move(segmenter));
    return InferAll(work, *input.frames, book);
  }

 private:
  struct Work {
    std::optional<RunFolder> run;
    RunDescription description;
    vision::OnlineSegmenterOptions options;
    int64_t run_from = 0;
    int64_t checkpoint_every = 0;
    std::string device;      // that makes the maps
    std::set<int64_t> done;  // frames that this program has worked on
    std::optional<ModelReplay> models;
    Shard shard;
  };

  absl::StatusOr<Work> OpenRun() const {
    Work work;
    EGOSIEVE_ASSIGN_OR_RETURN(work.run, RunFolder::Open(target_.run));
    EGOSIEVE_ASSIGN_OR_RETURN(work.description, work.run->ReadDescription());
    if (!work.description.maps_from.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat(target_.run, " holds maps alone; make more: egosieve infer ",
                       work.description.maps_from, " --out=", target_.run));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(work.run_from, NumberOf(work.description, "from"));
    EGOSIEVE_ASSIGN_OR_RETURN(work.checkpoint_every,
                              NumberOf(work.description, "checkpoint_every"));
    if (!KeepsModels(work.description)) {
      return absl::FailedPreconditionError(
          absl::StrCat("the run in ", target_.run,
                       " has all its maps and kept no models to make others from; segment the "
                       "drive with --learn_only for that"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(work.shard, ParseShard(shard_, work.checkpoint_every));
    EGOSIEVE_ASSIGN_OR_RETURN(work.options, ReadInferenceOptions(work.description.flags));
    if (stride_ > 0 && stride_ != work.options.stride_pixels && target_.is_run()) {
      return absl::InvalidArgumentError(absl::StrCat("--stride=", stride_, " is not the run's ",
                                                     work.options.stride_pixels,
                                                     "; give the maps a folder with --out"));
    }
    if (stride_ > 0) work.options.stride_pixels = stride_;
    EGOSIEVE_ASSIGN_OR_RETURN(const bool is_growing, FolderLock::IsTaken(target_.run));
    if (!is_growing) EGOSIEVE_RETURN_IF_ERROR(ChooseLines(*work.run, range_).status());
    return work;
  }

  absl::StatusOr<DriveInput> OpenInput(const Work& work) const {
    const std::string path = input_.empty() ? work.description.input.path : input_;
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenDriveInput(path, work.run_from));
    if (input.description.fingerprint != work.description.input.fingerprint) {
      return absl::FailedPreconditionError(absl::StrCat(path, " is not the input of the run in ",
                                                        target_.run, "; give that with --input"));
    }
    return input;
  }

  bool IsDue(const Work& work, int64_t index) const {
    return range_.Contains(index) && (index - work.run_from) % every_ == 0 &&
           work.shard.Contains(index);
  }

  // Frames whose maps are due and missing. A frame that could not be read gets the map of the last
  // readable frame before it, so that map is made, too.
  std::vector<int64_t> WantedFrames(const Work& work, MapBook& book) const {
    std::vector<int64_t> wanted;
    const FrameLine* before = nullptr;
    for (const FrameLine& line : work.models->lines()) {
      const bool failed = line.outcome == FrameLine::Outcome::kFailed;
      const bool again = target_.overwrite && target_.is_run();
      if (IsDue(work, line.index) && work.done.count(line.index) == 0 &&
          (again || !book.Holds(line.index))) {
        const bool needs_it = failed && before != nullptr && !book.Holds(before->index) &&
                              (wanted.empty() || wanted.back() < before->index);
        if (needs_it) wanted.push_back(before->index);
        wanted.push_back(line.index);
      }
      if (!failed && (line.index - work.run_from) % every_ == 0) before = &line;
    }
    return wanted;
  }

  // Adds, to a folder of --out, the lines of this shard and those of wanted frames outside it.
  absl::Status EnterLines(const Work& work, const std::vector<int64_t>& wanted,
                          MapBook& book) const {
    if (target_.is_run()) return absl::OkStatus();
    for (FrameLine line : work.models->lines()) {
      if (!(range_.Contains(line.index) && work.shard.Contains(line.index)) &&
          !std::binary_search(wanted.begin(), wanted.end(), line.index)) {
        continue;
      }
      line.width_pixels = line.height_pixels = 0;
      line.dynamic_share = 0.0;
      line.map_device.clear();
      EGOSIEVE_RETURN_IF_ERROR(book.Add(line));
    }
    return absl::OkStatus();
  }

  // The frames [begin, end) of `wanted` between which no checkpoint would save replaying.
  static size_t EndOfStretch(const Work& work, const std::vector<int64_t>& wanted, size_t begin) {
    size_t end = begin + 1;
    const int64_t every = work.checkpoint_every;
    while (end < wanted.size() &&
           (every == 0 || wanted[end] / every <= wanted[end - 1] / every + 1)) {
      ++end;
    }
    return end;
  }

  // One stretch of frames in their order; false if interrupted.
  absl::StatusOr<bool> InferStretch(Work& work, absl::Span<const int64_t> wanted,
                                    vision::FrameSource& frames, MapBook& book,
                                    Progress& progress) const {
    EGOSIEVE_RETURN_IF_ERROR(work.models->MoveTo(wanted.front()));
    const auto is_wanted = [&wanted](int64_t index) {
      return std::binary_search(wanted.begin(), wanted.end(), index);
    };
    vision::PipelineOptions pipeline;
    pipeline.overlap = kernels::MaximumThreads() > 1;
    pipeline.first_frame = wanted.front();
    pipeline.end_frame = wanted.back() + 1;
    pipeline.checkpoint_interval = work.checkpoint_every;
    pipeline.wants_map = is_wanted;
    pipeline.recorded_step = [&](int64_t index) { return work.models->StepOf(index); };
    EGOSIEVE_ASSIGN_OR_RETURN(
        const vision::PipelineSummary summary,
        vision::RunPipeline(frames, work.models->Lend(pipeline.end_frame), pipeline,
                            InterruptionRequested, [&](const vision::SegmentedFrame& frame) {
                              if (!is_wanted(frame.index)) return absl::OkStatus();
                              EGOSIEVE_RETURN_IF_ERROR(book.Write(frame));
                              work.done.insert(frame.index);
                              progress.Advance();
                              return absl::OkStatus();
                            }));
    if (summary.stopped) return false;
    if (frames.next_index() < pipeline.end_frame) {
      return absl::DataLossError(absl::StrCat(
          frames.description(), " ends at frame ", frames.next_index(), ", the run at frame ",
          work.models->lines().back().index, "; give the run's input with --input"));
    }
    return true;
  }

  // Follows a run that segment is still writing, to its end; false if interrupted.
  absl::StatusOr<bool> InferWhatComes(Work& work, vision::FrameSource& frames,
                                      MapBook& book) const {
    while (true) {
      // Asked first: if segment has ended by now, the lines read next are complete.
      EGOSIEVE_ASSIGN_OR_RETURN(const bool is_growing, FolderLock::IsTaken(target_.run));
      EGOSIEVE_RETURN_IF_ERROR(work.models->ReadLines());
      EGOSIEVE_RETURN_IF_ERROR(book.Refresh());
      const std::vector<int64_t> wanted = WantedFrames(work, book);
      EGOSIEVE_RETURN_IF_ERROR(EnterLines(work, wanted, book));
      Progress progress("infer", progress_, static_cast<int64_t>(wanted.size()));
      for (size_t begin = 0; begin < wanted.size();) {
        const size_t end = EndOfStretch(work, wanted, begin);
        EGOSIEVE_ASSIGN_OR_RETURN(
            const bool finished,
            InferStretch(work, absl::MakeConstSpan(wanted).subspan(begin, end - begin), frames,
                         book, progress));
        if (!finished) return false;
        begin = end;
      }
      progress.Finish();
      const bool has_range = range_.to >= 0 && !work.models->lines().empty() &&
                             work.models->lines().back().index >= range_.to;
      if (!is_growing || has_range) break;
      for (auto wait = kPoll; wait.count() > 0 && !InterruptionRequested(); wait -= kShortPoll) {
        std::this_thread::sleep_for(kShortPoll);
      }
      if (InterruptionRequested()) return false;
    }
    EGOSIEVE_RETURN_IF_ERROR(ChooseLines(*work.run, range_).status());
    return true;
  }

  absl::StatusOr<ExitCode> InferAll(Work& work, vision::FrameSource& frames, MapBook& book) const {
    const auto start = std::chrono::steady_clock::now();
    const absl::StatusOr<bool> finished = InferWhatComes(work, frames, book);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const bool had_nothing_to_do = work.done.empty() && finished.ok() && *finished;
    const absl::Status told =
        had_nothing_to_do ? absl::OkStatus() : target_.TellEnd(finished, seconds);
    EGOSIEVE_RETURN_IF_ERROR(finished.status());
    EGOSIEVE_RETURN_IF_ERROR(told);
    result_.Tell(name(),
                 {{"run", target_.path()},
                  {"maps", work.done.size()},
                  {"seconds", seconds},
                  {"device", work.device}},
                 had_nothing_to_do
                     ? absl::StrCat(target_.path(), " holds these maps already\n")
                     : absl::StrFormat("%d maps in %s on %s: %s\n", work.done.size(),
                                       DescribeDuration(seconds), work.device, target_.path()));
    if (!*finished) {
      return absl::CancelledError(absl::StrCat("interrupted; the ", work.done.size(),
                                               " maps made are whole, the same command goes on"));
    }
    const bool failed = std::any_of(
        work.models->lines().begin(), work.models->lines().end(), [&](const FrameLine& line) {
          return line.outcome == FrameLine::Outcome::kFailed && IsDue(work, line.index);
        });
    return failed ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

  MapTarget target_;
  std::string input_, shard_;
  FrameRange range_;
  int64_t every_ = 1;
  int stride_ = 0;
  ThreadsFlag threads_;
  DeviceFlag device_;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeInferCommand() { return std::make_unique<InferCommand>(); }

}  // namespace egosieve::tools
