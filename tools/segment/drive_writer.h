// Writes what the segmenter makes of a drive into its run folder, frame by frame.
#ifndef EGOSIEVE_TOOLS_SEGMENT_DRIVE_WRITER_H_
#define EGOSIEVE_TOOLS_SEGMENT_DRIVE_WRITER_H_

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/run_folder/baselines.h"
#include "tools/run_folder/doubtful_frames.h"
#include "tools/run_folder/run_folder.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {

// A frame's line, but for its outcome's cost in `writing` and its saturated deviations.
FrameLine MakeLine(const vision::SegmentedFrame& frame);

// 16-bit images of a map, as RunFolder writes them; views of `map`.
FrameMaps MakeMaps(const vision::SegmentationMap& map);

// Gives `line`, of a frame that could not be read, the map of `before`, which has one.
absl::Status CopyMaps(const RunFolder& folder, const FrameLine& before, FrameLine& line);

struct DriveWriterOptions {
  // The frames that get a map; null: all.
  std::function<bool(int64_t index)> wants_map;
  // Of a run whose maps are made later: every checkpoint is a place to begin.
  bool keep_checkpoints = false;
  std::string device;  // that computes; lines name it where it is not the run's
};

class DriveWriter {
 public:
  struct Counts {
    explicit Counts(const RunDescription& description)
        : grid(description.grid), baselines(description) {}

    kernels::ImageGrid grid;  // the run's
    Baselines baselines;
    int64_t answered = 0;  // could be read and have their map
    int64_t learnt = 0;
    int64_t failed = 0;         // could not be read
    int64_t other_sizes = 0;    // answered, of another size than the run's first frame
    std::string first_failure;  // its reason
    DoubtfulFrames doubtful;
    std::string last_not_learnt;  // reason of the last that has a map and was not learnt from

    void Add(const FrameLine& line);
  };

  // `folder` was made for a new run; `description` is written as it is.
  static absl::StatusOr<DriveWriter> Start(const RunFolder& folder,
                                           const RunDescription& description,
                                           DriveWriterOptions options = {});

  // `folder` holds a run of which `lines` are kept: the log is cut after them.
  static absl::StatusOr<DriveWriter> Continue(const RunFolder& folder,
                                              const RunDescription& description,
                                              const std::vector<FrameLine>& lines,
                                              DriveWriterOptions options = {});

  // The maps, the step, then the line, then the checkpoint where there is one. After an error the
  // folder holds the frames before. image: the picture's name, for the line.
  absl::Status Write(const vision::SegmentedFrame& frame, const std::string& image = "");

  // Writes how the run ended into run.json. `seconds` is what this part of it took.
  absl::Status Finish(const std::string& ended, const std::string& message, double seconds);

  const Counts& counts() const { return counts_; }
  const FrameLine& last_line() const { return last_line_; }

 private:
  DriveWriter(const RunFolder& folder, const RunDescription& description, LineLog log,
              DriveWriterOptions options)
      : folder_(folder),
        description_(description),
        log_(std::move(log)),
        options_(std::move(options)),
        counts_(description) {}

  // A frame that could not be read gets the last map before it, where there is one.
  absl::Status AnswerFromBefore(FrameLine& line) const;
  void Remember(FrameLine line);

  RunFolder folder_;
  RunDescription description_;
  LineLog log_;
  DriveWriterOptions options_;
  Counts counts_;
  FrameLine last_line_;
  FrameLine last_with_map_;
};

// Now, in ISO 8601, to the second.
std::string UtcNow();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_DRIVE_WRITER_H_
