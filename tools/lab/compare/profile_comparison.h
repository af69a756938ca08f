// Comparisons of the same methods on the same drives under several profiles, side by side.
#ifndef EGOSIEVE_TOOLS_LAB_COMPARE_PROFILE_COMPARISON_H_
#define EGOSIEVE_TOOLS_LAB_COMPARE_PROFILE_COMPARISON_H_

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/lab/compare/comparison_table.h"

namespace egosieve::tools {

struct ProfileComparison {
  std::string profile;                       // or a variant's name
  std::map<std::string, std::string> flags;  // DescribeOptions of its segmenter
  std::vector<DriveComparison> drives;
  ComparisonSummary summary;  // of these drives
};

// One line per method with a group of columns per profile, then each profile's own table (ToTable
// of comparison_table.h).
std::string ToTable(const std::vector<ProfileComparison>& profiles);
// One line per profile, drive, method and frame.
std::string ToCsv(const std::vector<ProfileComparison>& profiles);
nlohmann::ordered_json ToJson(const std::vector<ProfileComparison>& profiles);

// Which claims of the paper these figures support or not, one sentence each; empty unless the first
// method is arcsine. Whether a method improves over time is judged by its lead over `labels`, which
// learns nothing, because the drive itself may become easier.
std::vector<std::string> CompareWithPaper(const ComparisonSummary& summary);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_COMPARE_PROFILE_COMPARISON_H_
