// Results of a comparison over all its drives.
//
//   AUC (frames)   mean over the scored frames, of all drives, that have one
//   AUC (drives)   mean over drives of the mean over frames
//   pooled AUC     of all scored pixels together
//   no prior       AUC (drives) without the location prior
//   IoU            of the pixels with a probability above the threshold, averaged as AUC (drives);
//                  only frames with movers
//   difference     AUC of the first method minus that of another one, over frames
//                  (block_bootstrap.h) and over drives; both methods with or both without the
//                  location prior; for IoU over drives
//   slope          AUC per frame as a function of the frame's number, common to all drives
//                  (SlopeBootstrap); likewise for the lead over the method `labels`, which learns
//                  nothing
//   gain           mean AUC of each drive's last third of frames minus that of its first third
#ifndef EGOSIEVE_TOOLS_LAB_COMPARE_COMPARISON_TABLE_H_
#define EGOSIEVE_TOOLS_LAB_COMPARE_COMPARISON_TABLE_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/lab/compare/block_bootstrap.h"
#include "tools/lab/compare/drive_comparison.h"

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
  std::optional<BootstrapInterval> slope_of_lead;  // of its AUC minus that of `labels`
  double own_milliseconds = 0.0;                   // median over frames
  double model_size = 0.0;                         // mean over the drives' last frames
  // The first method minus this one; absent for the first method itself.
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

// Needs at least one drive that did not fail.
ComparisonSummary Summarise(const std::vector<DriveComparison>& drives,
                            const BootstrapOptions& bootstrap);

// The method's mean IoU over frames, at the single threshold that maximises it.
std::optional<double> BestIou(const DriveScores& scores);

std::string ToTable(const std::vector<DriveComparison>& drives, const ComparisonSummary& summary);
// One line per drive, method and frame: prefix, sequence, method, frame, AUC, model size, own and
// shared milliseconds.
void AppendCsv(const std::string& prefix, const std::vector<DriveComparison>& drives,
               std::string* csv);
nlohmann::ordered_json ToJson(const std::vector<DriveComparison>& drives,
                              const ComparisonSummary& summary);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_COMPARE_COMPARISON_TABLE_H_
