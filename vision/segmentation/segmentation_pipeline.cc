#include "vision/segmentation/segmentation_pipeline.h"

#include <algorithm>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "kernels/base/exception_status.h"
#include "kernels/base/status_macros.h"
#include "vision/labelling/stopwatch.h"
#include "vision/segmentation/bounded_queue.h"

namespace egosieve::vision {
namespace {

// A frame in the pipeline, with the data that later stages need.
struct InFlight {
  SegmentedFrame result;
  std::shared_ptr<const ExtractedFrame> extracted;
  std::vector<std::shared_ptr<const ExtractedFrame>> ahead;  // of the frames after this one
  double extract_milliseconds = 0.0, prepare_milliseconds = 0.0;
  std::string labeller_state;  // where a checkpoint is due
  std::optional<MapPosterior> posterior;
};

// The stages as functions of one frame. The drivers below run them in turn or on threads.
class Stages {
 public:
  Stages(FrameSource& source, OnlineSegmenter& segmenter, const PipelineOptions& options,
         const std::function<bool()>& stop_requested, const SegmentedFrameSink& sink)
      : source_(source),
        segmenter_(segmenter),
        options_(options),
        stop_requested_(stop_requested),
        sink_(sink) {}

  // Nothing at the end of the run.
  absl::StatusOr<std::optional<InFlight>> Read() {
    if (options_.end_frame >= 0 &&
        source_.next_index() >= options_.end_frame + AheadFrames() * options_.frame_step) {
      return std::nullopt;
    }
    if (stop_requested_ && stop_requested_()) {
      summary_.stopped = true;
      return std::nullopt;
    }
    InFlight item;
    Stopwatch watch;
    EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, source_.Next());
    item.result.read_milliseconds = watch.LapMilliseconds();
    if (auto* end = std::get_if<EndOfFrames>(&read)) {
      summary_.warning = std::move(end->warning);
      return std::nullopt;
    }
    if (auto* damaged = std::get_if<DamagedFrame>(&read)) {
      item.result.index = damaged->index;
      item.result.record.frame_index = damaged->index;
      item.result.record.reason = damaged->reason;
      item.result.damage = std::move(damaged->reason);
    } else {
      item.result.frame = std::move(std::get<Frame>(read));
      item.result.index = item.result.frame.index;
    }
    return item;
  }

  // Also prepares the pair with the frame before, so that labels, which need the frames in order,
  // take less time.
  absl::Status Extract(InFlight& item) {
    if (item.result.damage.has_value()) return absl::OkStatus();
    Stopwatch watch;
    EGOSIEVE_ASSIGN_OR_RETURN(item.extracted, segmenter_.labeller().Extract(item.result.frame));
    item.extract_milliseconds = watch.LapMilliseconds();
    if (before_ != nullptr) {
      EGOSIEVE_RETURN_IF_ERROR(segmenter_.labeller().Prepare(*before_, *item.extracted));
    }
    item.prepare_milliseconds = watch.LapMilliseconds();
    before_ = item.extracted;
    return absl::OkStatus();
  }

  // Frames wait here until the frames ahead of them have been extracted. Returns the frames that
  // need not wait any longer. Frames after end_frame serve as frames ahead only.
  std::vector<InFlight> LookAhead(InFlight item) {
    waiting_.push_back(std::move(item));
    std::vector<InFlight> ready;
    while (static_cast<int>(waiting_.size()) > AheadFrames()) Release(ready);
    return ready;
  }
  // For the end of the input. After a stop request, frames whose frames ahead were not all read are
  // left to the run that continues this one.
  std::vector<InFlight> EndLookAhead() {
    std::vector<InFlight> ready;
    while (!summary_.stopped && !waiting_.empty()) Release(ready);
    return ready;
  }

  absl::Status Label(InFlight& item) const {
    if (item.extracted != nullptr) {
      EGOSIEVE_ASSIGN_OR_RETURN(item.result.labels,
                                segmenter_.labeller().Label(std::move(item.extracted), item.ahead));
      item.ahead.clear();
    }
    if (IsCheckpointDue(item)) item.labeller_state = segmenter_.labeller().state();
    return absl::OkStatus();
  }

  absl::Status Learn(InFlight& item) {
    if (item.result.damage.has_value()) {
      ++summary_.damaged_frames;
    } else {
      EGOSIEVE_RETURN_IF_ERROR(LearnLabels(item));
      ++summary_.segmented_frames;
    }
    if (IsCheckpointDue(item)) {
      EGOSIEVE_ASSIGN_OR_RETURN(item.result.checkpoint, segmenter_.Checkpoint(item.labeller_state));
    }
    return absl::OkStatus();
  }

  absl::Status Infer(InFlight& item) const {
    if (!item.posterior) return absl::OkStatus();
    EGOSIEVE_ASSIGN_OR_RETURN(
        item.result.map, segmenter_.Infer(item.result.frame, *item.posterior, item.result.record));
    item.posterior.reset();
    return absl::OkStatus();
  }

  absl::Status Sink(const InFlight& item) const { return sink_(item.result); }

  // Whether frames not yet learnt are to be left out.
  bool IsStopping() {
    if (!stopped_learning_) stopped_learning_ = stop_requested_ && stop_requested_();
    return stopped_learning_;
  }

  PipelineSummary TakeSummary() {
    summary_.stopped |= stopped_learning_;
    return std::move(summary_);
  }

 private:
  int AheadFrames() const { return segmenter_.options().ahead_frames; }

  void Release(std::vector<InFlight>& ready) {
    InFlight item = std::move(waiting_.front());
    waiting_.pop_front();
    if (options_.end_frame >= 0 && item.result.index >= options_.end_frame) return;
    for (const InFlight& next : waiting_) {
      if (next.extracted != nullptr) item.ahead.push_back(next.extracted);
    }
    ready.push_back(std::move(item));
  }

  absl::Status LearnLabels(InFlight& item) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        OnlineSegmenter::Learnt learnt,
        segmenter_.LearnLabels(item.result.frame, std::move(item.result.labels)));
    item.posterior = std::move(learnt.posterior);
    item.result.labels = std::move(learnt.labels);
    item.result.record = std::move(learnt.record);
    // The labeller reports the features' time with that of the pair that used them. Without a pair
    // extraction is the only such time.
    StageMilliseconds& milliseconds = item.result.record.milliseconds;
    milliseconds.features =
        std::max(milliseconds.features, item.extract_milliseconds - milliseconds.equalization) +
        item.prepare_milliseconds;
    return absl::OkStatus();
  }

  bool IsCheckpointDue(const InFlight& item) const {
    return options_.checkpoint_interval > 0 &&
           (item.result.index + 1) % options_.checkpoint_interval < options_.frame_step;
  }

  FrameSource& source_;
  OnlineSegmenter& segmenter_;
  const PipelineOptions& options_;
  const std::function<bool()>& stop_requested_;
  const SegmentedFrameSink& sink_;
  // Written by Read (stopped, warning) and Learn (counts): different members; read after the join.
  PipelineSummary summary_;
  bool stopped_learning_ = false;  // used by the learning stage
  // Used by the extracting stage.
  std::deque<InFlight> waiting_;
  std::shared_ptr<const ExtractedFrame> before_;  // the last one extracted
};

absl::Status RunInTurn(Stages& stages) {
  while (true) {
    EGOSIEVE_ASSIGN_OR_RETURN(std::optional<InFlight> item, stages.Read());
    const bool at_end = !item.has_value();
    if (!at_end) EGOSIEVE_RETURN_IF_ERROR(stages.Extract(*item));
    for (InFlight& ready : at_end ? stages.EndLookAhead() : stages.LookAhead(std::move(*item))) {
      EGOSIEVE_RETURN_IF_ERROR(stages.Label(ready));
      EGOSIEVE_RETURN_IF_ERROR(stages.Learn(ready));
      EGOSIEVE_RETURN_IF_ERROR(stages.Infer(ready));
      EGOSIEVE_RETURN_IF_ERROR(stages.Sink(ready));
    }
    if (at_end) return absl::OkStatus();
  }
}

// Keeps the first error and ends the stages before the one that failed. Later stages finish their
// frames.
class OverlappedRun {
 public:
  OverlappedRun(Stages& stages, int queue_capacity) : stages_(stages) {
    for (int i = 0; i < kQueues; ++i) {
      queues_.push_back(std::make_unique<BoundedQueue<InFlight>>(queue_capacity));
    }
  }

  // Reads on the caller's thread. Returns false if the system refuses a thread for a stage; then no
  // frame has been read.
  bool Run() {
    bool complete = false;
    std::vector<std::thread> threads;
    try {
      threads.reserve(kQueues);
      for (int stage = kQueues - 1; stage >= 0; --stage) {
        threads.emplace_back([this, stage] { RunStage(stage); });
      }
      complete = true;
    } catch (const std::exception&) {
      for (const auto& queue : queues_) queue->Cancel();
    }
    if (complete) ReadAll();
    for (std::thread& thread : threads) {
      thread.join();
    }
    return complete;
  }

  const absl::Status& status() const { return status_; }

 private:
  static constexpr int kQueues = 5, kLearnStage = 2;

  void Fail(const absl::Status& status, int queues_before) {
    {
      std::lock_guard lock(mutex_);
      status_.Update(status);
    }
    Cancel(queues_before);
  }

  void Cancel(int queues_before) {
    {
      std::lock_guard lock(mutex_);
      goes_on_ = false;
    }
    for (int i = 0; i < queues_before; ++i) {
      queues_[i]->Cancel();
    }
  }

  void ReadAll() {
    const absl::Status status = kernels::CatchExceptions([&]() -> absl::Status {
      while (true) {
        EGOSIEVE_ASSIGN_OR_RETURN(std::optional<InFlight> item, stages_.Read());
        if (!item.has_value() || !queues_[0]->Push(*std::move(item))) return absl::OkStatus();
      }
    });
    if (!status.ok()) Fail(status, 0);
    queues_[0]->Close();
  }

  // Runs on its own thread: from the stage's queue to the next queue.
  void RunStage(int stage) {
    const absl::Status status =
        kernels::CatchExceptions([&] { return stage == 0 ? ExtractAll() : TransformAll(stage); });
    if (!status.ok()) Fail(status, stage + 1);
    if (stage + 1 < kQueues) queues_[stage + 1]->Close();
  }

  absl::Status ExtractAll() {
    bool goes_on = true;
    while (goes_on) {
      std::optional<InFlight> item = queues_[0]->Pop();
      std::vector<InFlight> ready;
      goes_on = item.has_value();
      if (goes_on) {
        EGOSIEVE_RETURN_IF_ERROR(stages_.Extract(*item));
        ready = stages_.LookAhead(std::move(*item));
      } else if (GoesOn()) {
        ready = stages_.EndLookAhead();
      }
      for (InFlight& frame : ready) goes_on &= queues_[1]->Push(std::move(frame));
    }
    return absl::OkStatus();
  }

  bool GoesOn() {
    std::lock_guard lock(mutex_);
    return goes_on_;
  }

  absl::Status TransformAll(int stage) {
    while (std::optional<InFlight> item = queues_[stage]->Pop()) {
      if (stage == kLearnStage && stages_.IsStopping()) {
        Cancel(stage + 1);
        break;
      }
      EGOSIEVE_RETURN_IF_ERROR(stage == 1             ? stages_.Label(*item)
                               : stage == kLearnStage ? stages_.Learn(*item)
                               : stage == 3           ? stages_.Infer(*item)
                                                      : stages_.Sink(*item));
      if (stage + 1 < kQueues && !queues_[stage + 1]->Push(*std::move(item))) break;
    }
    return absl::OkStatus();
  }

  Stages& stages_;
  std::vector<std::unique_ptr<BoundedQueue<InFlight>>> queues_;
  std::mutex mutex_;
  absl::Status status_;
  bool goes_on_ = true;
};

}  // namespace

absl::StatusOr<PipelineSummary> RunPipeline(FrameSource& source, OnlineSegmenter& segmenter,
                                            const PipelineOptions& options,
                                            const std::function<bool()>& stop_requested,
                                            const SegmentedFrameSink& sink) {
  EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(options.first_frame));
  Stages stages(source, segmenter, options, stop_requested, sink);
  EGOSIEVE_RETURN_IF_ERROR(kernels::CatchExceptions([&] {
    if (options.overlap) {
      OverlappedRun overlapped(stages, options.queue_capacity);
      if (overlapped.Run()) return overlapped.status();
    }
    return RunInTurn(stages);
  }));
  return stages.TakeSummary();
}

}  // namespace egosieve::vision
