// Turns a run's maps into masks, numbers and tracks, chunk by chunk.
//
//   chunk    up to 32 consecutive frames of one size. The frames around it on which its results
//            depend (vision/masks/map_window.h) are read with it and kept for the next chunk
//   files    of a chunk: frame products, then rows of tracks.csv, then reconstruct.json, which
//            records the progress and the movers' state. A run that was killed continues at its
//            last chunk, and gives the same bytes
//
// Memory: the frames of a chunk and at most 24 on each side of it, for any length of the drive.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/threads_flag.h"
#include "tools/refine/frame_products.h"
#include "tools/run_folder/run_folder.h"
#include "vision/frame/frame_source.h"
#include "vision/masks/map_window.h"
#include "vision/masks/mover_links.h"
#include "vision/masks/mover_tracker.h"

namespace egosieve::tools {

struct RefineOptions {
  ProductChoice what;
  ClassThresholds classes;
  vision::ObjectThresholds objects;
  vision::ObjectThresholds mask = {0.5, 0.7};
  vision::MapWindowOptions window;
  std::string input;  // if not empty, replaces the path in run.json
  // Continue where a former call with the same options stopped; begin where there is none.
  bool resume = false;

  absl::Status Validate() const;
};

// The flags of `refine`: which frames of a run are refined, how, and what is written.
struct RefineFlags {
  std::string directory;
  std::string what = ProductChoice().ToText();
  RefineOptions options;  // but its `what`
  FrameRange range;
  ThreadsFlag threads;
  ProgressFlag progress;
  ResultFlag result;

  void AddFlags(CLI::App& app);
};

// Errors of usage, of the run folder, of the input and of the environment; Cancelled, with whole
// chunks so far.
absl::StatusOr<ExitCode> RunRefine(const RefineFlags& flags);

// Whether the last refinement of the run was completed.
bool IsRefined(const RunFolder& folder);

// Whether `resume` would find a refinement of these lines with these options.
absl::StatusOr<bool> IsResumable(const RunFolder& folder, const std::vector<FrameLine>& lines,
                                 const RefineOptions& options);

// In the run folder: how far it is refined, and by which options.
inline constexpr char kRefineState[] = "reconstruct.json";

class RefineRun {
 public:
  // lines: the requested ones. Errors name the fault of the input and its remedy.
  static absl::StatusOr<std::unique_ptr<RefineRun>> Open(const RunFolder& folder,
                                                         const std::vector<FrameLine>& lines,
                                                         const RefineOptions& options);

  // Frames that have a map and could be read; how many of them were done before.
  int64_t frames() const { return frames_; }
  int64_t frames_done_before() const { return done_before_; }

  // Works to the end. `after_frame` is called for every frame; returning false cancels after its
  // chunk.
  absl::Status Run(const std::function<bool()>& after_frame);

 private:
  RefineRun(const RunFolder& folder, const RefineOptions& options)
      : folder_(folder), options_(options) {}

  absl::Status Begin();
  absl::Status StartTracks();
  absl::Status RestoreState();
  absl::Status SaveState(size_t done);
  absl::StatusOr<vision::WindowFrame> ReadFrame(size_t i);
  // Reads the frames on which the results of [begin, end) depend, and drops others.
  absl::Status MoveWindowAround(size_t begin, size_t end);
  // Refined maps of the window's frames [begin, end), with the rounding of their files.
  std::vector<cv::Mat1f> RefinedMapsOf(size_t begin, size_t end) const;
  absl::Status RunChunk(size_t begin, size_t end);
  // The movers' numbers in the frames [begin, end), at working resolution. results: of these frames
  // and, where the next frame tells which of the last movers are glimpses (mover_tracker.h), of that.
  std::vector<cv::Mat1w> NumberMovers(size_t begin, size_t end,
                                      const std::vector<FrameResult>& results);
  // Gives the tracker's numbers in the frames [begin, ...) of `tracked` the numbers of the movers.
  void LinkMovers(size_t begin, const std::vector<vision::TrackedFrame>& tracked,
                  std::vector<cv::Mat1w>& numbers);
  absl::Status WriteChunk(size_t begin, std::vector<FrameResult>& results);

  RunFolder folder_;
  IgnoredAreas ignored_;
  RefineOptions options_;
  RunDescription description_;
  std::vector<FrameLine> lines_;
  int64_t frames_ = 0;
  std::vector<bool> has_map_of_its_own_;
  std::unique_ptr<vision::FrameSource> source_;
  vision::MoverTracker tracker_;
  vision::MoverLinks links_;
  std::unique_ptr<LineLog> tracks_;
  int64_t track_rows_ = 0;
  int64_t done_before_ = 0;
  size_t window_begin_ = 0;  // index in lines_ of the window's first frame
  std::vector<vision::WindowFrame> window_;
};

}  // namespace egosieve::tools
