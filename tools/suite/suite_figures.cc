#include "tools/suite/suite_figures.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <string>
#include <utility>

#include "absl/strings/str_format.h"
#include "tools/plots/score_figures.h"

namespace egosieve::tools {
namespace {

std::vector<std::string> Profiles(const std::vector<SequenceResult>& results) {
  std::vector<std::string> profiles;
  for (const SequenceResult& result : results) {
    if (std::find(profiles.begin(), profiles.end(), result.profile) == profiles.end()) {
      profiles.push_back(result.profile);
    }
  }
  return profiles;
}

// One figure of the table, with one bar per sequence and profile.
Figure BySequence(const std::vector<SequenceResult>& results, const char* name, const char* title,
                  const char* caption) {
  Figure figure{std::string("by_sequence_") + name, title, caption, "", title};
  const auto wanted =
      std::find_if(SuiteFigures().begin(), SuiteFigures().end(),
                   [&](const SuiteFigure& known) { return std::string(known.name) == name; });
  for (const std::string& profile : Profiles(results)) {
    Series series{profile, {}, {}};
    series.style = Series::Style::kBars;
    figure.categories.clear();
    for (const SequenceResult& result : results) {
      if (result.profile != profile) continue;
      series.x.push_back(static_cast<double>(figure.categories.size()));
      series.y.push_back(wanted->of(result).value_or(std::numeric_limits<double>::quiet_NaN()));
      figure.categories.push_back(result.sequence.name);
    }
    figure.series.push_back(std::move(series));
  }
  figure.y_range = std::pair(0.0, 1.0);
  return figure;
}

}  // namespace

PlotPage MakeSuitePage(const SequenceList& list, const std::vector<SequenceResult>& results,
                       const SuiteSummary& summary) {
  PlotPage page;
  page.title = "Egosieve on many sequences";
  page.paragraphs = {absl::StrFormat(
      "%d runs scored, %d failed. Curves are over all scored pixels of all sequences with masks; "
      "tracks are points, and have a bar only.",
      results.size() - summary.failed, summary.failed)};
  page.table = ToTable(list, results, summary);
  page.figures = {
      BySequence(results, "mean_auc", "AUC",
                 "Mean over frames of the area under the ROC curve; 0.5 is guessing."),
      BySequence(
          results, "mean_iou", "mean IoU, declared threshold",
          "Mean over the frames with movers of the intersection over union, when pixels from "
          "the declared threshold on are called dynamic. No bar: 0, or none."),
  };
  std::deque<DriveScores> merged;
  std::vector<NamedScores> scores;
  for (const std::string& profile : Profiles(results)) {
    DriveScores* own = nullptr;
    for (const SequenceResult& result : results) {
      if (result.profile != profile || !result.run ||
          result.run->evaluation.truth_kind == "tracks") {
        continue;
      }
      if (own == nullptr) {
        own = &merged.emplace_back(result.run->scores);
      } else {
        own->Merge(result.run->scores);
      }
    }
    if (own != nullptr) scores.push_back({profile, own});
  }
  page.figures.push_back(RocFigure(scores));
  page.figures.push_back(PrecisionRecallFigure(scores));
  page.figures.push_back(IouByThresholdFigure(scores));
  page.figures.push_back(ReliabilityFigure(scores));
  page.figures.push_back(SparsificationFigure(scores));
  return page;
}

}  // namespace egosieve::tools
