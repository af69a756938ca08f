#include "tools/lab/tune_defaults/setting_grid.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "tools/evaluation/table_cell.h"

namespace egosieve::tools {
namespace {

constexpr char kDefaults[] = "as it is";

std::optional<size_t> FigureNamed(const std::string& name) {
  for (size_t i = 0; i < SuiteFigures().size(); ++i) {
    if (SuiteFigures()[i].name == name) return i;
  }
  return std::nullopt;
}

// Mean over the groups, except "all", that have the figure.
std::optional<double> MeanOverGroups(const std::string& figure, const std::string& profile,
                                     const SuiteSummary& summary) {
  const std::optional<size_t> index = FigureNamed(figure);
  double sum = 0.0;
  int count = 0;
  for (const auto& [key, figures] : summary.figures) {
    if (key.first == "all" || key.second != profile || !index || !figures[*index]) continue;
    sum += figures[*index]->mean;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

}  // namespace

absl::StatusOr<std::vector<Setting>> ParseGrid(absl::string_view grid, int most) {
  std::vector<Setting> settings = {Setting{}};
  for (absl::string_view entry : absl::StrSplit(grid, ';', absl::SkipWhitespace())) {
    entry = absl::StripAsciiWhitespace(entry);
    const std::pair<std::string, std::string> parts =
        absl::StrSplit(entry, absl::MaxSplits('=', 1));
    const std::vector<std::string> values = absl::StrSplit(parts.second, ',', absl::SkipEmpty());
    if (parts.first.empty() || values.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat("'", entry, "' is not FLAG=VALUE,VALUE; as in --grid='budget=1000,1500'"));
    }
    std::vector<Setting> combined;
    for (const Setting& setting : settings) {
      for (const std::string& value : values) {
        Setting with = setting;
        with.flags.push_back(absl::StrCat("--", parts.first, "=", value));
        combined.push_back(std::move(with));
      }
    }
    settings = std::move(combined);
  }
  if (static_cast<int>(settings.size()) > most) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "the grid has %d settings; give fewer values, %d at most", settings.size(), most));
  }
  if (!settings.front().flags.empty()) settings.insert(settings.begin(), Setting{});
  for (Setting& setting : settings) {
    setting.name = setting.flags.empty()
                       ? kDefaults
                       : absl::StrReplaceAll(absl::StrJoin(setting.flags, ","), {{"--", ""}});
    setting.folder = absl::StrReplaceAll(setting.name, {{" ", "_"}, {"/", "_"}, {",", "+"}});
  }
  return settings;
}

SettingScore ScoreOfSetting(const std::string& name, const std::string& profile,
                            const SuiteSummary& summary) {
  SettingScore score;
  score.name = name;
  score.auc = MeanOverGroups("mean_auc", profile, summary);
  score.iou = MeanOverGroups("mean_iou_best_threshold", profile, summary);
  score.failed = summary.failed;
  const auto all = summary.figures.find({"all", profile});
  const std::optional<size_t> auc = FigureNamed("mean_auc");
  if (all != summary.figures.end() && auc && all->second[*auc]) {
    score.least_auc = all->second[*auc]->least;
  }
  return score;
}

std::string RankTable(std::vector<SettingScore> scores, double noise) {
  const std::vector<SettingScore> in_order = scores;
  std::stable_sort(scores.begin(), scores.end(), [](const SettingScore& a, const SettingScore& b) {
    if ((a.failed > 0) != (b.failed > 0)) return b.failed > 0;
    return a.auc.value_or(0.0) > b.auc.value_or(0.0);
  });
  std::string table =
      absl::StrFormat("%-44s %8s %8s %8s %8s\n", "setting", "AUC", "worst", "IoU best", "failed");
  for (const SettingScore& score : scores) {
    absl::StrAppendFormat(&table, "%-44s%s%s%s %8d\n", score.name, TableCell(score.auc),
                          TableCell(score.least_auc), TableCell(score.iou), score.failed);
  }
  if (scores.empty() || !scores.front().auc || scores.front().failed > 0) {
    return absl::StrCat(table, "chosen: none, every setting failed somewhere\n");
  }
  const auto chosen =
      std::find_if(in_order.begin(), in_order.end(), [&](const SettingScore& score) {
        return score.failed == 0 && score.auc && *score.auc >= *scores.front().auc - noise;
      });
  absl::StrAppendFormat(&table, "chosen: %s (within %.3f of the best AUC)\n", chosen->name, noise);
  return table;
}

}  // namespace egosieve::tools
