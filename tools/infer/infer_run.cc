#include "tools/infer/infer_run.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/interruption.h"
#include "tools/infer/map_book.h"
#include "tools/infer/model_replay.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/segment/drive_input.h"
#include "tools/segment/segment_flags.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {
namespace {

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

class InferRun {
 public:
  explicit InferRun(const InferFlags& flags) : flags_(flags) {}

  absl::StatusOr<ExitCode> Run() {
    EGOSIEVE_RETURN_IF_ERROR(flags_.range.Validate());
    EGOSIEVE_ASSIGN_OR_RETURN(Work work, OpenRun());
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenInput(work));
    EGOSIEVE_RETURN_IF_ERROR(flags_.target.CheckApartFrom(*input.frames));
    flags_.threads.Apply();
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, flags_.device.Open());
    work.device = DescribeDevice(device.info);
    if (InterruptionRequested()) {
      return absl::CancelledError("interrupted; nothing was written");
    }
    // Keeps models and maps from being removed meanwhile.
    EGOSIEVE_ASSIGN_OR_RETURN(const FolderLock reading, FolderLock::Use(flags_.target.run));
    EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<FolderLock> writing,
                              RunFolder::TakeOrMake(flags_.target.path()));
    EGOSIEVE_ASSIGN_OR_RETURN(
        MapBook book,
        flags_.target.Open(*work.run, work.description, work.options.stride_pixels, work.device));
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
  };

  absl::StatusOr<Work> OpenRun() const {
    Work work;
    EGOSIEVE_ASSIGN_OR_RETURN(work.run, RunFolder::Open(flags_.target.run));
    EGOSIEVE_ASSIGN_OR_RETURN(work.description, work.run->ReadDescription());
    if (!work.description.maps_from.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat(flags_.target.run, " holds maps alone; make more: egosieve infer ",
                       work.description.maps_from, " --out=", flags_.target.run));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(work.run_from, NumberOf(work.description, "from"));
    EGOSIEVE_ASSIGN_OR_RETURN(work.checkpoint_every,
                              NumberOf(work.description, "checkpoint_every"));
    if (!KeepsModels(work.description)) {
      return absl::FailedPreconditionError(
          absl::StrCat("the run in ", flags_.target.run,
                       " has all its maps and kept no models to make others from; segment the "
                       "drive with --learn_only for that"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(work.options, ReadInferenceOptions(work.description.flags));
    if (flags_.stride > 0 && flags_.stride != work.options.stride_pixels &&
        flags_.target.is_run()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--stride=", flags_.stride, " is not the run's ", work.options.stride_pixels,
                       "; give the maps a folder with --out"));
    }
    if (flags_.stride > 0) work.options.stride_pixels = flags_.stride;
    EGOSIEVE_RETURN_IF_ERROR(ChooseLines(*work.run, flags_.range).status());
    return work;
  }

  absl::StatusOr<DriveInput> OpenInput(const Work& work) const {
    const std::string path = flags_.input.empty() ? work.description.input.path : flags_.input;
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenDriveInput(path, work.run_from));
    if (input.description.fingerprint != work.description.input.fingerprint) {
      return absl::FailedPreconditionError(absl::StrCat(
          path, " is not the input of the run in ", flags_.target.run, "; give that with --input"));
    }
    return input;
  }

  bool IsDue(const Work& work, int64_t index) const {
    return flags_.range.Contains(index) && (index - work.run_from) % flags_.every == 0;
  }

  // Frames whose maps are due and missing. A frame that could not be read gets the map of the last
  // readable frame before it, so that map is made, too.
  std::vector<int64_t> WantedFrames(const Work& work, MapBook& book) const {
    std::vector<int64_t> wanted;
    const FrameLine* before = nullptr;
    for (const FrameLine& line : work.models->lines()) {
      const bool failed = line.outcome == FrameLine::Outcome::kFailed;
      const bool again = flags_.target.overwrite && flags_.target.is_run();
      if (IsDue(work, line.index) && work.done.count(line.index) == 0 &&
          (again || !book.Holds(line.index))) {
        const bool needs_it = failed && before != nullptr && !book.Holds(before->index) &&
                              (wanted.empty() || wanted.back() < before->index);
        if (needs_it) wanted.push_back(before->index);
        wanted.push_back(line.index);
      }
      if (!failed && (line.index - work.run_from) % flags_.every == 0) before = &line;
    }
    return wanted;
  }

  // Adds, to a folder of --out, the lines of the range and those of wanted frames outside it.
  absl::Status EnterLines(const Work& work, const std::vector<int64_t>& wanted,
                          MapBook& book) const {
    if (flags_.target.is_run()) return absl::OkStatus();
    for (FrameLine line : work.models->lines()) {
      if (!flags_.range.Contains(line.index) &&
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

  // All maps that are due and missing; false if interrupted.
  absl::StatusOr<bool> InferMissing(Work& work, vision::FrameSource& frames, MapBook& book) const {
    EGOSIEVE_RETURN_IF_ERROR(work.models->ReadLines());
    const std::vector<int64_t> wanted = WantedFrames(work, book);
    EGOSIEVE_RETURN_IF_ERROR(EnterLines(work, wanted, book));
    Progress progress("infer", flags_.progress, static_cast<int64_t>(wanted.size()));
    for (size_t begin = 0; begin < wanted.size();) {
      const size_t end = EndOfStretch(work, wanted, begin);
      EGOSIEVE_ASSIGN_OR_RETURN(
          const bool finished,
          InferStretch(work, absl::MakeConstSpan(wanted).subspan(begin, end - begin), frames, book,
                       progress));
      if (!finished) return false;
      begin = end;
    }
    progress.Finish();
    return true;
  }

  absl::StatusOr<ExitCode> InferAll(Work& work, vision::FrameSource& frames, MapBook& book) const {
    const auto start = std::chrono::steady_clock::now();
    const absl::StatusOr<bool> finished = InferMissing(work, frames, book);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const bool had_nothing_to_do = work.done.empty() && finished.ok() && *finished;
    const absl::Status told =
        had_nothing_to_do ? absl::OkStatus() : flags_.target.TellEnd(finished, seconds);
    EGOSIEVE_RETURN_IF_ERROR(finished.status());
    EGOSIEVE_RETURN_IF_ERROR(told);
    flags_.result.Tell(
        "infer",
        {{"run", flags_.target.path()},
         {"maps", work.done.size()},
         {"seconds", seconds},
         {"device", work.device}},
        had_nothing_to_do
            ? absl::StrCat(flags_.target.path(), " holds these maps already\n")
            : absl::StrFormat("%d maps in %s on %s: %s\n", work.done.size(),
                              DescribeDuration(seconds), work.device, flags_.target.path()));
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

  const InferFlags& flags_;
};

}  // namespace

absl::StatusOr<ExitCode> RunInfer(const InferFlags& flags) { return InferRun(flags).Run(); }

}  // namespace egosieve::tools
