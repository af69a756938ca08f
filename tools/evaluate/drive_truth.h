// The truth of a drive, whatever its form, compared with a map frame by frame.
//
//   masks       a folder of masks (truth_masks.h)
//   synthetic   a folder that `egosieve synthesize` wrote, or its masks/: objects are known as well
//   tracks      a file of labelled points (track_truth.h): the map is interpolated linearly between
//               grid pixels at each point; outlines and objects have no meaning
//
// A track's frame k is the frame whose name has the number k, where the drive is a folder and every
// name has its own number; else the frame with index k.
#ifndef EGOSIEVE_TOOLS_EVALUATE_DRIVE_TRUTH_H_
#define EGOSIEVE_TOOLS_EVALUATE_DRIVE_TRUTH_H_

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/image_grid.h"
#include "tools/evaluate/truth_masks.h"
#include "tools/evaluation/drive_scores.h"
#include "tools/evaluation/synthetic_truth.h"
#include "tools/evaluation/track_truth.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// What the truth is matched with.
struct TruthFrames {
  std::vector<std::string> names;  // without extension, by index; empty where frames have none
  std::vector<int64_t> indices;    // of the frames that there are, for masks matched by order
};

class DriveTruth {
 public:
  // NotFound where there is nothing at `path`; DataLoss for a damaged file; FailedPrecondition for
  // tracks without points or of one class; InvalidArgument where masks cannot be matched as asked.
  static absl::StatusOr<DriveTruth> Open(const std::string& path, const TruthFrames& frames,
                                         MatchMasks match);

  const std::string& path() const { return path_; }
  const std::string& kind() const { return kind_; }              // masks, synthetic, tracks
  const std::string& matched_by() const { return matched_by_; }  // name, number, order
  const std::set<int64_t>& frames() const { return frames_; }    // that have a truth
  bool Has(int64_t frame) const { return frames_.count(frame) > 0; }
  bool scattered() const { return kind_ == "tracks"; }
  int64_t points() const;  // of tracks, in all frames

  // Maps at the grid's pixels beside the truth of a frame that has one; the result points into this
  // object. `points_outside` counts points that are not in the image, which are left out.
  // OutOfRange where a mask has another size than the image; DataLoss where a file cannot be read.
  absl::StatusOr<ScoredFrame> Compare(int64_t frame, const kernels::ImageGrid& grid,
                                      const FrameMaps& maps, double deviation_full_scale,
                                      int64_t* points_outside) const;

  // 0, 128 or 255 at any pixel of a frame with a mask. Errors as above; FailedPrecondition for
  // tracks.
  absl::StatusOr<cv::Mat1b> ReadMask(int64_t frame, cv::Size size) const;
  // The labelled points of a frame; empty unless the truth is of tracks.
  const std::vector<LabelledPoint>& PointsOf(int64_t frame) const;

 private:
  absl::Status OpenTracks(const std::string& path, const TruthFrames& frames, MatchMasks match);
  absl::Status OpenMasks(const std::string& path, const TruthFrames& frames, MatchMasks match);
  ScoredFrame CompareTracks(int64_t frame, const kernels::ImageGrid& grid, const FrameMaps& maps,
                            double deviation_full_scale, int64_t* points_outside) const;

  std::string path_, kind_, matched_by_;
  std::set<int64_t> frames_;
  std::map<int64_t, std::string> masks_;  // paths
  SyntheticTruth synthetic_;
  std::map<int64_t, std::vector<LabelledPoint>> tracks_;
};

// Whether no pixel or point of the frame is known to be static or dynamic.
bool IsVoid(const ScoredFrame& frame);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_DRIVE_TRUTH_H_
