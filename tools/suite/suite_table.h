// A suite's results as one table: sequences, means over groups of them, spread, and failures.
//
//   mean, deviation  over the sequences that have the figure; deviation with n - 1, absent for one
//   one threshold    for each of 0.05 .. 0.95: the mean over sequences of the mean IoU over frames
#ifndef EGOSIEVE_TOOLS_SUITE_SUITE_TABLE_H_
#define EGOSIEVE_TOOLS_SUITE_SUITE_TABLE_H_

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/suite/suite_run.h"

namespace egosieve::tools {

// A figure of one sequence.
struct SuiteFigure {
  const char* name;     // in files
  const char* heading;  // above its column
  std::optional<double> (*of)(const SequenceResult& result);
};

// In the order of the columns.
const std::vector<SuiteFigure>& SuiteFigures();

struct Spread {
  int count = 0;
  double mean = 0.0;
  std::optional<double> deviation;
  double least = 0.0;
  double most = 0.0;
};

// Absent without values.
std::optional<Spread> SpreadOf(const std::vector<double>& values);

// The group's name ("all" is one), then the profile's.
using GroupKey = std::pair<std::string, std::string>;

struct SuiteSummary {
  std::map<GroupKey, std::vector<std::optional<Spread>>> figures;  // in the order of SuiteFigures
  // By threshold step (drive_scores.h); empty if no sequence has masks with movers.
  std::map<GroupKey, std::vector<double>> iou_by_threshold;
  int failed = 0;
};

SuiteSummary SummariseSuite(const std::vector<SequenceResult>& results);

std::string ToTable(const SequenceList& list, const std::vector<SequenceResult>& results,
                    const SuiteSummary& summary);
// Markdown, one row per group ("all" included) and profile: the mean and the least value, over the
// group's sequences, of the AUC (mean over frames), and of J, the mean over frames of the IoU at
// the declared threshold, if the truth is masks.
std::string ToMarkdown(const std::vector<SequenceResult>& results);
std::string ToCsv(const std::vector<SequenceResult>& results);
nlohmann::ordered_json ToJson(const SequenceList& list, const std::vector<SequenceResult>& results,
                              const SuiteSummary& summary);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SUITE_SUITE_TABLE_H_
