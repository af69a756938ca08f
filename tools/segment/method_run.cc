#include "tools/segment/method_run.h"

#include <utility>
#include <variant>

#include "kernels/base/status_macros.h"

namespace egosieve::tools {

absl::StatusOr<vision::PipelineSummary> RunMethod(vision::FrameSource& source,
                                                  vision::MethodSegmenter& segmenter,
                                                  const vision::PipelineOptions& options,
                                                  const std::function<bool()>& stop_requested,
                                                  const vision::SegmentedFrameSink& sink) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(options.first_frame));
  vision::PipelineSummary summary;
  while (options.end_frame < 0 || source.next_index() < options.end_frame) {
    summary.stopped = stop_requested();
    if (summary.stopped) break;
    EGOSIEVE_ASSIGN_OR_RETURN(vision::FrameRead read, source.Next());
    if (auto* end = std::get_if<vision::EndOfFrames>(&read)) {
      summary.warning = std::move(end->warning);
      break;
    }
    vision::SegmentedFrame result;
    if (auto* damaged = std::get_if<vision::DamagedFrame>(&read)) {
      result.index = result.record.frame_index = damaged->index;
      result.record.reason = damaged->reason;
      result.damage = std::move(damaged->reason);
      ++summary.damaged_frames;
    } else {
      result.frame = std::move(std::get<vision::Frame>(read));
      result.index = result.frame.index;
      EGOSIEVE_ASSIGN_OR_RETURN(vision::MethodAnswers answers, segmenter.Process(result.frame));
      result.labels = std::move(answers.labels);
      result.map = std::move(answers.answers.front().map);
      result.record = std::move(answers.answers.front().record);
      ++summary.segmented_frames;
      summary.unlearnt_frames += result.record.learnt ? 0 : 1;
    }
    EGOSIEVE_RETURN_IF_ERROR(sink(result));
  }
  return summary;
}

}  // namespace egosieve::tools
