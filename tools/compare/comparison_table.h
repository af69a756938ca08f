// What a comparison found over all its drives.
//
//   AUC (frames)   mean over all scored frames of all drives that have one
//   AUC (drives)   mean over drives of the mean over frames
//   pooled AUC     of all scored pixels together
//   no prior       AUC (drives) without the location prior
//   IoU            of what has a probability above the threshold, as AUC (drives); in frames with
//                  movers
//   difference     of the first method to another one in AUC, frame by frame (block_bootstrap.h),
//                  and over drives; of both or of neither with the location prior; in IoU over
//                  drives
//   slope          AUC a frame over the frame's number, common to all drives (SlopeBootstrap);
//                  of the lead over the method `labels`, which learns nothing, likewise
//   gain           mean AUC of each drive's last third of frames less that of its first third
#ifndef EGOSIEVE_TOOLS_COMPARE_COMPARISON_TABLE_H_
#define EGOSIEVE_TOOLS_COMPARE_COMPARISON_TABLE_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/compare/block_bootstrap.h"
#include "tools/compare/drive_comparison.h"

namespace egosieve::tools {

struct MethodSummary {
  std::string method;
  bool probabilistic = false;
  DriveScores scores;  // of all drives
  std::optional<double> frame_auc;
  std::optional<double> drive_auc;
  std::optional<double> drive_auc_without_prior;
  std::optional<double> drive_iou;
  std::optional<double> gain;
  std::optional<BootstrapInterval> slope;
  std::optional<BootstrapInterval> slope_of_lead;  // of its AUC less that of `labels`
  double own_milliseconds = 0.0;                   // median over frames
  double model_size = 0.0;                         // mean over the drives' last frames
  // Of the first method to this one; absent for itself.
  std::optional<BootstrapInterval> difference;
  std::optional<BootstrapInterval> difference_over_drives;
  std::optional<BootstrapInterval> difference_over_drives_without_prior;
  std::optional<BootstrapInterval> iou_difference_over_drives;
};

struct ComparisonSummary {
  std::vector<MethodSummary> methods;
  RocHistogram at_features;
  LabelCounts labels;
  double shared_milliseconds = 0.0;  // median over frames
  int drives = 0;
  int failed = 0;
};

// At least one drive that did not fail.
ComparisonSummary Summarise(const std::vector<DriveComparison>& drives,
                            const BootstrapOptions& bootstrap);

// The mean IoU of the method's frames at the one threshold that is best for them all.
std::optional<double> BestIou(const DriveScores& scores);

std::string ToTable(const std::vector<DriveComparison>& drives, const ComparisonSummary& summary);
// One line per drive, method and frame: prefix, sequence, method, frame, AUC, model size, own and
// shared milliseconds.
void AppendCsv(const std::string& prefix, const std::vector<DriveComparison>& drives,
               std::string* csv);
nlohmann::ordered_json ToJson(const std::vector<DriveComparison>& drives,
                              const ComparisonSummary& summary);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_COMPARE_COMPARISON_TABLE_H_
