#include "tools/suite/further_table.h"

#include <algorithm>
#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tools/evaluation/table_cell.h"

namespace egosieve::tools {
namespace {

std::string Cell(const std::optional<double>& value) { return TableCell(value, 12, 3); }

// One table for each variant with boxes, in the order of the results.
std::string BoxTables(const std::vector<SequenceResult>& results) {
  std::vector<std::string> variants;
  std::map<std::string, BoxScores> pooled;
  for (const SequenceResult& result : results) {
    if (!result.further.boxes) continue;
    const auto [own, is_new] = pooled.try_emplace(result.profile, *result.further.boxes);
    if (is_new) {
      variants.push_back(result.profile);
    } else {
      own->second.Merge(*result.further.boxes);
    }
  }
  std::string tables;
  for (const std::string& variant : variants) {
    absl::StrAppend(&tables, variant, ", all sequences with boxes\n", pooled.at(variant).ToTable());
  }
  return tables;
}

bool HasCamera(const FurtherScores& scores) {
  return scores.trajectory || scores.focal_error_percent || scores.own_vehicle_marked;
}

}  // namespace

std::string FurtherTable(const std::vector<SequenceResult>& results) {
  std::string table = BoxTables(results);
  if (std::none_of(results.begin(), results.end(),
                   [](const SequenceResult& result) { return HasCamera(result.further); })) {
    return table;
  }
  absl::StrAppendFormat(&table, "%-32s %-10s %12s %12s %12s %12s %12s %12s\n", "camera", "profile",
                        "rotation d/s", "neighbours", "direction d", "focal %", "own marked",
                        "row shift");
  for (const SequenceResult& result : results) {
    const FurtherScores& scores = result.further;
    if (!HasCamera(scores)) continue;
    const auto row = [&](const std::optional<TrajectoryErrors>& errors, int shift) {
      const TrajectoryErrors shown = errors.value_or(TrajectoryErrors());
      absl::StrAppendFormat(&table, "%-32s %-10s", result.sequence.name, result.profile);
      absl::StrAppend(&table, Cell(shown.rotation), Cell(shown.rotation_neighbours),
                      Cell(shown.direction), Cell(scores.focal_error_percent),
                      Cell(scores.own_vehicle_marked), absl::StrFormat(" %12d\n", shift));
    };
    row(scores.trajectory, 0);
    if (scores.shifted) row(scores.shifted, scores.row_shift);
  }
  return table;
}

}  // namespace egosieve::tools
