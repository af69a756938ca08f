// Writes the segmenter's results for a drive into its run folder, frame by frame.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/run_folder/baselines.h"
#include "tools/run_folder/doubtful_frames.h"
#include "tools/run_folder/run_folder.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {

// A frame's line, without its time for `writing` and its number of saturated deviations.
FrameLine MakeLine(const vision::SegmentedFrame& frame);

class DriveWriter {
 public:
  struct Counts {
    explicit Counts(const RunDescription& description)
        : grid(description.grid), baselines(description) {}

    vision::ImageGrid grid;  // the run's
    Baselines baselines;
    int64_t answered = 0;  // frames that could be read and have their map
    int64_t learnt = 0;
    int64_t failed = 0;         // frames that could not be read
    int64_t other_sizes = 0;    // answered, but of another size than the run's first frame
    std::string first_failure;  // its reason
    DoubtfulFrames doubtful;
    std::string last_not_learnt;  // reason of the last frame with a map that was not learnt from

    void Add(const FrameLine& line);
  };

  // A new run, or one of `lines`, after which its log is cut. `description` is written as it is.
  // device: the one that computes; lines name it if it is not the run's.
  static absl::StatusOr<DriveWriter> Open(const RunFolder& folder,
                                          const RunDescription& description,
                                          const std::vector<FrameLine>& lines, std::string device);

  // Writes the maps, the line, and the checkpoint if there is one, in this order. After
  // an error the folder holds the frames before this one. image: the picture's name, for the line.
  absl::Status Write(const vision::SegmentedFrame& frame, const std::string& image = "");

  // Writes how the run ended into run.json. `seconds`: duration of this part of the run.
  absl::Status Finish(const std::string& ended, const std::string& message, double seconds);

  const Counts& counts() const { return counts_; }
  const FrameLine& last_line() const { return last_line_; }

 private:
  DriveWriter(const RunFolder& folder, const RunDescription& description, LineLog log,
              std::string device)
      : folder_(folder),
        description_(description),
        log_(std::move(log)),
        device_(std::move(device)),
        counts_(description) {}

  // Gives a frame that could not be read the last map before it, if there is one.
  absl::Status AnswerFromBefore(FrameLine& line) const;
  void Remember(FrameLine line);

  RunFolder folder_;
  RunDescription description_;
  LineLog log_;
  std::string device_;
  Counts counts_;
  FrameLine last_line_;
  FrameLine last_with_map_;
};

// The present time in ISO 8601, to the second.
std::string UtcNow();

// Warnings, one line each, and exit code of a run that reached its end: kFramesFailed if frames
// could not be read, if a video ended early, or if the model learnt from nothing or from fewer than
// half of the frames (tools/run_folder/doubtful_frames.h).
struct RunVerdict {
  ExitCode code = ExitCode::kDone;
  std::vector<std::string> warnings;
};

// end_warning: EndOfFrames::warning, empty if there is none.
RunVerdict JudgeRun(const DriveWriter::Counts& counts, const std::string& end_warning);

}  // namespace egosieve::tools
