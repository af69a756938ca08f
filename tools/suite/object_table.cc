#include "tools/suite/object_table.h"

#include <algorithm>
#include <map>

#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

// Objects of one variant, pooled over the sequences.
struct Objects {
  std::map<std::string, ObjectRecall> groups;
  int64_t frames = 0;
  int64_t false_objects = 0;
};

}  // namespace

std::string ObjectTable(const std::vector<SequenceResult>& results) {
  std::vector<std::string> variants;  // in the order of the results
  std::map<std::string, Objects> pooled;
  std::map<std::string, int64_t> counts;  // objects of the group, largest count over the variants
  for (const SequenceResult& result : results) {
    if (!result.run || result.run->scores.recall().size() < 2) continue;
    const DriveScores& scores = result.run->scores;
    if (std::find(variants.begin(), variants.end(), result.profile) == variants.end()) {
      variants.push_back(result.profile);
    }
    Objects& own = pooled[result.profile];
    own.frames += scores.frames_with_objects();
    own.false_objects += scores.false_objects();
    for (const auto& [group, recall] : scores.recall()) {
      ObjectRecall& sum = own.groups[group];
      sum.objects += recall.objects;
      sum.found_at_30 += recall.found_at_30;
      counts[group] = std::max(counts[group], sum.objects);
    }
  }
  if (variants.empty()) return "";
  std::string table = absl::StrFormat("%-32s %8s", "movers found (IoU 0.3)", "objects");
  for (const std::string& variant : variants) absl::StrAppendFormat(&table, " %12s", variant);
  table.push_back('\n');
  for (const auto& [group, count] : counts) {
    absl::StrAppendFormat(&table, "%-32s %8d", group, count);
    for (const std::string& variant : variants) {
      const ObjectRecall& recall = pooled[variant].groups[group];
      if (recall.objects == 0) {
        absl::StrAppendFormat(&table, " %12s", "-");
      } else {
        absl::StrAppendFormat(
            &table, " %12.3f",
            static_cast<double>(recall.found_at_30) / static_cast<double>(recall.objects));
      }
    }
    table.push_back('\n');
  }
  absl::StrAppendFormat(&table, "%-32s %8s", "false objects per frame", "");
  for (const std::string& variant : variants) {
    const Objects& own = pooled[variant];
    absl::StrAppendFormat(&table, " %12.3f",
                          static_cast<double>(own.false_objects) /
                              static_cast<double>(std::max<int64_t>(own.frames, 1)));
  }
  table.push_back('\n');
  return table;
}

}  // namespace egosieve::tools
