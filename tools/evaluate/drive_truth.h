// The truth of a drive in any form, compared with maps frame by frame.
//
//   masks       a folder of masks (truth_masks.h)
//   synthetic   a folder that `egosieve synthesize` wrote, or its masks/: also has objects
//   tracks      a file of labelled points (track_truth.h): the map is interpolated linearly between
//               grid pixels at each point; there are no outlines and no objects
//
// Frame k of a track is the frame whose name has the number k, if the drive is a folder and all
// names have different numbers; else the frame with index k.
#ifndef EGOSIEVE_TOOLS_EVALUATE_DRIVE_TRUTH_H_
#define EGOSIEVE_TOOLS_EVALUATE_DRIVE_TRUTH_H_

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/image_grid.h"
#include "tools/evaluation/drive_scores.h"
#include "tools/evaluation/synthetic_truth.h"
#include "tools/evaluation/track_truth.h"
#include "tools/masks/truth_masks.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// The frames that the truth is matched with.
struct TruthFrames {
  std::vector<std::string> names;  // without extension, by index; empty if frames have none
  std::vector<int64_t> indices;    // of the existing frames, for masks matched by order
};

class DriveTruth {
 public:
  // NotFound if nothing is at `path`; DataLoss for a damaged file; FailedPrecondition for tracks
  // without points or with one class; InvalidArgument if masks cannot be matched as requested.
  static absl::StatusOr<DriveTruth> Open(const std::string& path, const TruthFrames& frames,
                                         MatchMasks match);

  const std::string& path() const { return path_; }
  const std::string& kind() const { return kind_; }              // masks, synthetic, tracks
  const std::string& matched_by() const { return matched_by_; }  // name, number, order
  const std::set<int64_t>& frames() const { return frames_; }    // frames with a truth
  bool Has(int64_t frame) const { return frames_.count(frame) > 0; }
  bool scattered() const { return kind_ == "tracks"; }
  int64_t points() const;  // of tracks, in all frames

  // Puts a frame's maps at the grid's pixels beside its truth, which must exist; the result points
  // into this object. `points_outside` counts points outside the image, which are left out.
  // OutOfRange if a mask differs in size from the image; DataLoss if a file cannot be read.
  absl::StatusOr<ScoredFrame> Compare(int64_t frame, const kernels::ImageGrid& grid,
                                      const FrameMaps& maps, double deviation_full_scale,
                                      int64_t* points_outside) const;

  // The mask of a frame that has one: 0, 128 or 255 at each pixel. Errors as above;
  // FailedPrecondition for tracks.
  absl::StatusOr<cv::Mat1b> ReadMask(int64_t frame, cv::Size size) const;
  // Numbers of the moving objects of a frame; empty if the truth does not distinguish objects.
  absl::StatusOr<cv::Mat1i> ReadIds(int64_t frame, cv::Size size) const;
  // Properties of the objects of a frame, by id; null if they are not known.
  const std::map<int, SyntheticObject>* ObjectsOf(int64_t frame) const;
  // The labelled points of a frame; empty unless the truth is tracks.
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

// Whether no pixel or point of the frame has a known label.
bool IsVoid(const ScoredFrame& frame);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_DRIVE_TRUTH_H_
