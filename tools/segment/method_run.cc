#include "tools/segment/method_run.h"

#include <deque>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "kernels/base/status_macros.h"

namespace egosieve::tools {
namespace {

// A frame that waits for later frames.
struct Waiting {
  int64_t index = 0;
  vision::FrameRead read;
  std::shared_ptr<const vision::ExtractedFrame> extracted;  // null if damaged
};

absl::StatusOr<Waiting> Extract(const vision::MethodSegmenter& segmenter, vision::FrameRead read) {
  Waiting waiting;
  if (const auto* frame = std::get_if<vision::Frame>(&read)) {
    waiting.index = frame->index;
    EGOSIEVE_ASSIGN_OR_RETURN(waiting.extracted, segmenter.Extract(*frame));
  } else {
    waiting.index = std::get<vision::DamagedFrame>(read).index;
  }
  waiting.read = std::move(read);
  return waiting;
}

}  // namespace

absl::StatusOr<vision::PipelineSummary> AnswerFrames(vision::FrameSource& source,
                                                     vision::MethodSegmenter& segmenter,
                                                     const vision::PipelineOptions& options,
                                                     const std::function<bool()>& stop_requested,
                                                     const AnsweredFrame& on_frame) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(options.first_frame));
  const int ahead_frames = segmenter.options().ahead_frames;
  vision::PipelineSummary summary;
  std::deque<Waiting> waiting;
  const auto release = [&]() -> absl::Status {
    Waiting item = std::move(waiting.front());
    waiting.pop_front();
    if (options.end_frame >= 0 && item.index >= options.end_frame) return absl::OkStatus();
    const auto* frame = std::get_if<vision::Frame>(&item.read);
    if (frame == nullptr) {
      ++summary.damaged_frames;
      return on_frame(item.read, nullptr);
    }
    std::vector<std::shared_ptr<const vision::ExtractedFrame>> ahead;
    for (const Waiting& next : waiting) {
      if (next.extracted != nullptr) ahead.push_back(next.extracted);
    }
    EGOSIEVE_ASSIGN_OR_RETURN(vision::MethodAnswers answers,
                              segmenter.Process(*frame, std::move(item.extracted), ahead));
    ++summary.segmented_frames;
    return on_frame(item.read, &answers);
  };
  const int64_t read_until = options.end_frame + ahead_frames * options.frame_step;
  while (options.end_frame < 0 || source.next_index() < read_until) {
    summary.stopped = stop_requested();
    if (summary.stopped) break;
    EGOSIEVE_ASSIGN_OR_RETURN(vision::FrameRead read, source.Next());
    if (auto* end = std::get_if<vision::EndOfFrames>(&read)) {
      summary.warning = std::move(end->warning);
      break;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(Waiting item, Extract(segmenter, std::move(read)));
    waiting.push_back(std::move(item));
    if (static_cast<int>(waiting.size()) > ahead_frames) EGOSIEVE_RETURN_IF_ERROR(release());
  }
  while (!summary.stopped && !waiting.empty()) EGOSIEVE_RETURN_IF_ERROR(release());
  return summary;
}

absl::StatusOr<vision::PipelineSummary> RunMethod(vision::FrameSource& source,
                                                  vision::MethodSegmenter& segmenter,
                                                  const vision::PipelineOptions& options,
                                                  const std::function<bool()>& stop_requested,
                                                  const vision::SegmentedFrameSink& sink) {
  return AnswerFrames(source, segmenter, options, stop_requested,
                      [&](vision::FrameRead& read, vision::MethodAnswers* answers) {
                        vision::SegmentedFrame result;
                        if (auto* damaged = std::get_if<vision::DamagedFrame>(&read)) {
                          result.index = result.record.frame_index = damaged->index;
                          result.record.reason = damaged->reason;
                          result.damage = std::move(damaged->reason);
                        } else {
                          result.frame = std::move(std::get<vision::Frame>(read));
                          result.index = result.frame.index;
                          result.labels = std::move(answers->labels);
                          result.map = std::move(answers->answers.front().map);
                          result.record = std::move(answers->answers.front().record);
                        }
                        return sink(result);
                      });
}

}  // namespace egosieve::tools
