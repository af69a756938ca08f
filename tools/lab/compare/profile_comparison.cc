#include "tools/lab/compare/profile_comparison.h"

#include <algorithm>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tools/evaluation/csv_table.h"
#include "tools/evaluation/table_cell.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;

const MethodSummary* Find(const ComparisonSummary& summary, const std::string& name) {
  for (const MethodSummary& method : summary.methods) {
    if (method.method == name) return &method;
  }
  return nullptr;
}

std::string SideBySide(const std::vector<ProfileComparison>& profiles) {
  std::string head = absl::StrFormat("%-22s", "profile"),
              names = absl::StrFormat("%-22s", "method");
  for (const ProfileComparison& profile : profiles) {
    absl::StrAppendFormat(&head, "   %-26s", profile.profile);
    absl::StrAppendFormat(&names, "   %8s %8s %8s", "AUC", "pooled", "IoU best");
  }
  std::string table = absl::StrCat(head, "\n", names, "\n");
  // All profiles have the same methods, except that a profile has none if all its drives failed.
  const auto longest =
      std::max_element(profiles.begin(), profiles.end(), [](const auto& a, const auto& b) {
        return a.summary.methods.size() < b.summary.methods.size();
      });
  if (longest == profiles.end()) return table;
  for (const MethodSummary& row : longest->summary.methods) {
    absl::StrAppendFormat(&table, "%-22s", row.method);
    for (const ProfileComparison& profile : profiles) {
      const MethodSummary* method = Find(profile.summary, row.method);
      std::optional<double> auc, pooled, iou;
      if (method != nullptr) {
        auc = method->frame_auc;
        pooled = method->scores.pooled().Auc();
        iou = BestIou(method->scores);
      }
      absl::StrAppend(&table, "  ", TableCell(auc), TableCell(pooled), TableCell(iou));
    }
    table.push_back('\n');
  }
  return table;
}

// Judges a claim that a figure is positive, by its interval.
const char* Verdict(const BootstrapInterval& interval) {
  return interval.low > 0.0 ? "shown" : interval.high < 0.0 ? "contradicted" : "not shown";
}

void TellOrder(const ComparisonSummary& summary, std::vector<std::string>& lines) {
  const auto tell = [&](const char* whose, const std::string& rival) {
    const MethodSummary* method = Find(summary, rival);
    if (method == nullptr || !method->difference) return;
    const BootstrapInterval& d = *method->difference;
    lines.push_back(
        absl::StrFormat("%s: arcsine ahead of %s: %s (AUC %+.3f, 95 %% from %+.3f to "
                        "%+.3f)",
                        whose, rival, Verdict(d), d.mean, d.low, d.high));
  };
  for (const char* rival : {"squared_exponential", "svm", "optical_flow", "ransac"}) {
    tell("the paper's claim", rival);
  }
  // The paper compares with sparse flow; dense flow is the stronger method.
  for (const char* rival : {"dense_optical_flow", "labels", "homography_flow"}) {
    tell("beyond the paper", rival);
  }
}

void TellTrends(const ComparisonSummary& summary, std::vector<std::string>& lines) {
  constexpr double kFrames = 100.0;
  for (const char* learner : {"arcsine", "squared_exponential", "svm"}) {
    const MethodSummary* method = Find(summary, learner);
    if (method == nullptr || !method->slope) continue;
    const bool has_lead = method->slope_of_lead.has_value();
    const BootstrapInterval& b = has_lead ? *method->slope_of_lead : *method->slope;
    lines.push_back(absl::StrFormat(
        "the paper's claim: %s improves over time: %s (%s %+.3f in 100 frames, 95 %% from %+.3f to "
        "%+.3f%s)",
        learner, Verdict(b), has_lead ? "lead over labels" : "AUC", kFrames * b.mean,
        kFrames * b.low, kFrames * b.high,
        has_lead ? absl::StrFormat("; AUC %+.3f", kFrames * method->slope->mean) : ""));
  }
}

void TellLabels(const ComparisonSummary& summary, std::vector<std::string>& lines) {
  const std::optional<double> precision = summary.labels.Precision();
  const std::optional<double> recall = summary.labels.Recall();
  if (!precision || !recall) return;
  lines.push_back(absl::StrFormat(
      "the paper's assumption: RANSAC's misclassifications are a minority: %s of the dynamic "
      "labels (%.0f %% of %d lie on movers), %s on movers (%.0f %% of their %d features are "
      "labelled dynamic)",
      *precision > 0.5 ? "holds" : "does not hold", 100.0 * *precision,
      summary.labels.dynamic[0] + summary.labels.dynamic[1],
      *recall > 0.5 ? "holds" : "does not hold", 100.0 * *recall, summary.labels.features[1]));
}

}  // namespace

std::vector<std::string> CompareWithPaper(const ComparisonSummary& summary) {
  std::vector<std::string> lines;
  if (summary.methods.empty() || summary.methods.front().method != "arcsine") return lines;
  TellOrder(summary, lines);
  TellTrends(summary, lines);
  TellLabels(summary, lines);
  return lines;
}

std::string ToTable(const std::vector<ProfileComparison>& profiles) {
  std::string table;
  if (profiles.size() > 1) absl::StrAppend(&table, SideBySide(profiles), "\n");
  for (const ProfileComparison& profile : profiles) {
    absl::StrAppend(&table, "profile ", profile.profile, "\n",
                    ToTable(profile.drives, profile.summary));
    if (&profile != &profiles.back()) table.push_back('\n');
  }
  return table;
}

std::string ToCsv(const std::vector<ProfileComparison>& profiles) {
  std::string csv =
      "profile,sequence,method,frame,auc,model_size,own_milliseconds,shared_milliseconds\n";
  for (const ProfileComparison& profile : profiles) {
    AppendCsv(absl::StrCat(CsvField(profile.profile), ","), profile.drives, &csv);
  }
  return csv;
}

Json ToJson(const std::vector<ProfileComparison>& profiles) {
  Json all = Json::array();
  for (const ProfileComparison& profile : profiles) {
    Json json = {{"profile", profile.profile}, {"flags", profile.flags}};
    json.update(ToJson(profile.drives, profile.summary));
    json["claims"] = CompareWithPaper(profile.summary);
    all.push_back(std::move(json));
  }
  return {{"profiles", std::move(all)}};
}

}  // namespace egosieve::tools
