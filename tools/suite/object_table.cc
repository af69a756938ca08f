#include "tools/suite/object_table.h"

#include <algorithm>
#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

// title: of the first column. Empty if no sequence has groups of objects.
std::string TableOf(const std::vector<SequenceResult>& results, const char* title,
                    const ObjectTally& (*objects_of)(const RunEvaluation&)) {
  std::vector<std::string> variants;  // in the order of the results
  std::map<std::string, ObjectTally> pooled;
  std::map<std::string, int64_t> counts;  // objects of the group, largest count over the variants
  for (const SequenceResult& result : results) {
    if (!result.run || objects_of(*result.run).recall().size() < 2) continue;
    if (std::find(variants.begin(), variants.end(), result.profile) == variants.end()) {
      variants.push_back(result.profile);
    }
    pooled[result.profile].Merge(objects_of(*result.run));
  }
  if (variants.empty()) return "";
  for (const auto& [variant, objects] : pooled) {
    for (const auto& [group, recall] : objects.recall()) {
      counts[group] = std::max(counts[group], recall.objects);
    }
  }
  std::string table = absl::StrFormat("%-32s %8s", title, "objects");
  for (const std::string& variant : variants) absl::StrAppendFormat(&table, " %12s", variant);
  table.push_back('\n');
  for (const auto& [group, count] : counts) {
    absl::StrAppendFormat(&table, "%-32s %8d", group, count);
    for (const std::string& variant : variants) {
      const auto& groups = pooled[variant].recall();
      const auto recall = groups.find(group);
      if (recall == groups.end()) {
        absl::StrAppendFormat(&table, " %12s", "-");
      } else {
        const auto objects = static_cast<double>(recall->second.objects);
        absl::StrAppendFormat(&table, "  %.3f %.3f",
                              static_cast<double>(recall->second.found_at_30) / objects,
                              static_cast<double>(recall->second.found_at_50) / objects);
      }
    }
    table.push_back('\n');
  }
  absl::StrAppendFormat(&table, "%-32s %8s", "false objects per frame", "");
  for (const std::string& variant : variants) {
    absl::StrAppendFormat(&table, " %12.3f", pooled[variant].FalseObjectsPerFrame().value_or(0.0));
  }
  table.push_back('\n');
  return table;
}

}  // namespace

std::string ObjectTable(const std::vector<SequenceResult>& results) {
  const std::string maps =
      TableOf(results, "movers in maps, IoU 0.3 and 0.5",
              [](const RunEvaluation& run) -> const ObjectTally& { return run.scores.objects(); });
  const std::string masks =
      TableOf(results, "movers in masks, IoU 0.3 and 0.5",
              [](const RunEvaluation& run) -> const ObjectTally& { return run.masks.objects(); });
  return absl::StrCat(maps, maps.empty() || masks.empty() ? "" : "\n", masks);
}

}  // namespace egosieve::tools
