// Comparisons of the same methods on the same drives under several profiles, side by side.
#ifndef EGOSIEVE_TOOLS_COMPARE_PROFILE_COMPARISON_H_
#define EGOSIEVE_TOOLS_COMPARE_PROFILE_COMPARISON_H_

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/compare/comparison_table.h"

namespace egosieve::tools {

struct ProfileComparison {
  std::string profile;                       // or a variant's name
  std::map<std::string, std::string> flags;  // DescribeOptions' of its segmenter
  std::vector<DriveComparison> drives;
  ComparisonSummary summary;  // of the drives
};

// A line a method with a group of columns a profile, then each profile's own table (ToTable of
// comparison_table.h).
std::string ToTable(const std::vector<ProfileComparison>& profiles);
// A line a profile, drive, method and frame.
std::string ToCsv(const std::vector<ProfileComparison>& profiles);
nlohmann::ordered_json ToJson(const std::vector<ProfileComparison>& profiles);

// What the paper claims and these figures do or do not show, a sentence each; empty unless the
// first method is arcsine. That a method improves over time is judged by its lead over `labels`,
// which learn nothing: the drive itself may get easier.
std::vector<std::string> CompareWithPaper(const ComparisonSummary& summary);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_COMPARE_PROFILE_COMPARISON_H_
