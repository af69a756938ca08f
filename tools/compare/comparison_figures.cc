#include "tools/compare/comparison_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tools/plots/score_figures.h"

namespace egosieve::tools {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kSmoothing = 4;  // frames to either side

std::vector<NamedScores> Scores(const ComparisonSummary& summary) {
  std::vector<NamedScores> all;
  for (const MethodSummary& method : summary.methods) {
    all.push_back({method.method, &method.scores, method.probabilistic});
  }
  return all;
}

// The mean over drives of what each says at a frame's place in its drive.
template <typename Value>
Series MeanByFrame(const std::vector<DriveComparison>& drives, size_t method, Value value) {
  std::map<int64_t, std::pair<double, int>> sums;
  Series series;
  for (const DriveComparison& drive : drives) {
    if (!drive.status.ok()) continue;
    series.name = drive.methods[method].method;
    for (const MethodFrame& frame : drive.methods[method].frames) {
      const std::optional<double> own = value(frame);
      if (!own) continue;
      sums[frame.index].first += *own;
      ++sums[frame.index].second;
    }
  }
  for (const auto& [index, sum] : sums) {
    series.x.push_back(static_cast<double>(index));
    series.y.push_back(sum.first / sum.second);
  }
  return series;
}

// A moving mean, so that nine methods can be told apart.
std::vector<double> Smoothed(const std::vector<double>& values) {
  std::vector<double> smoothed;
  const auto count = static_cast<int>(values.size());
  for (int i = 0; i < count; ++i) {
    const int low = std::max(0, i - kSmoothing), high = std::min(count - 1, i + kSmoothing);
    double sum = 0.0;
    for (int k = low; k <= high; ++k) sum += values[k];
    smoothed.push_back(sum / (high - low + 1));
  }
  return smoothed;
}

Figure RocWithFeatures(const ComparisonSummary& summary) {
  Figure figure = RocFigure(Scores(summary));
  Series features = RocSeries("ransac, at features only", summary.at_features);
  features.style = Series::Style::kDashed;
  if (!features.x.empty()) figure.series.push_back(std::move(features));
  absl::StrAppend(&figure.caption,
                  " Dashed: the RANSAC distance at the features themselves, where it is known. The "
                  "paper's figure 4a.");
  return figure;
}

Figure AucAgainstFrame(const std::vector<DriveComparison>& drives,
                       const ComparisonSummary& summary) {
  Figure figure{"auc_by_frame", "AUC against frame number",
                "Area under the ROC curve of single frames against their number, mean over drives, "
                "smoothed over nine frames. The paper's figure 4b, where it rises over the first "
                "frames.",
                "frame", "AUC"};
  for (size_t i = 0; i < summary.methods.size(); ++i) {
    Series series = MeanByFrame(drives, i, [](const MethodFrame& frame) { return frame.auc; });
    series.y = Smoothed(series.y);
    if (!series.x.empty()) figure.series.push_back(std::move(series));
  }
  return figure;
}

Figure SizeAgainstFrame(const std::vector<DriveComparison>& drives,
                        const ComparisonSummary& summary) {
  Figure figure{"model_size", "Model size against frame number",
                "Points that the model holds, mean over drives; methods without a memory hold none "
                "and are left out. The paper's figure 2e.",
                "frame", "points"};
  for (size_t i = 0; i < summary.methods.size(); ++i) {
    Series series = MeanByFrame(drives, i, [](const MethodFrame& frame) {
      return std::optional<double>(static_cast<double>(frame.model_size));
    });
    if (std::any_of(series.y.begin(), series.y.end(), [](double size) { return size > 0.0; })) {
      figure.series.push_back(std::move(series));
    }
  }
  return figure;
}

Figure TimeOfAFrame(const ComparisonSummary& summary) {
  Figure figure{"time", "Time a frame",
                "Median over frames of what a method takes beside what all share (features, labels "
                "and inputs: the last bar). Logarithmic.",
                "", "milliseconds"};
  Series series{"own time", {}, {}};
  series.style = Series::Style::kBars;
  for (const MethodSummary& method : summary.methods) {
    series.x.push_back(static_cast<double>(figure.categories.size()));
    series.y.push_back(method.own_milliseconds);
    figure.categories.push_back(method.method);
  }
  series.x.push_back(static_cast<double>(figure.categories.size()));
  series.y.push_back(summary.shared_milliseconds);
  figure.categories.push_back("shared");
  figure.series.push_back(std::move(series));
  figure.logarithmic_y = true;
  return figure;
}

Figure DifferencesFigure(const ComparisonSummary& summary) {
  const std::string first = summary.methods.empty() ? "" : summary.methods.front().method;
  Figure figure{
      "differences", absl::StrCat("AUC of ", first, " less that of each method"),
      "Mean difference over frames, with the interval that holds 95 % of the block "
      "bootstrap's resamples. Above 0: the first method is better; an interval that holds "
      "0 decides nothing.",
      "", "difference in AUC"};
  Series series{"difference", {}, {}};
  series.style = Series::Style::kIntervals;
  for (const MethodSummary& method : summary.methods) {
    if (!method.difference) continue;
    series.x.push_back(static_cast<double>(figure.categories.size()));
    series.y.push_back(method.difference->mean);
    series.low.push_back(method.difference->low);
    series.high.push_back(method.difference->high);
    figure.categories.push_back(method.method);
  }
  figure.series.push_back(std::move(series));
  return figure;
}

Figure DrivesFigure(const std::vector<DriveComparison>& drives, const ComparisonSummary& summary) {
  Figure figure{"drives", "AUC by drive",
                "Mean over each drive's frames of the area under the ROC curve.", "", "AUC"};
  for (size_t i = 0; i < summary.methods.size(); ++i) {
    Series series{summary.methods[i].method, {}, {}};
    series.style = Series::Style::kBars;
    for (const DriveComparison& drive : drives) {
      if (!drive.status.ok()) continue;
      series.x.push_back(static_cast<double>(series.x.size()));
      series.y.push_back(drive.methods[i].scores.Mean(&FrameScores::auc).value_or(kNone));
      if (i == 0) figure.categories.push_back(drive.sequence.name);
    }
    figure.series.push_back(std::move(series));
  }
  figure.y_range = std::pair(0.0, 1.0);
  return figure;
}

const MethodSummary* Find(const ComparisonSummary& summary, const std::string& name) {
  for (const MethodSummary& method : summary.methods) {
    if (method.method == name) return &method;
  }
  return nullptr;
}

// Whether arcsine is ahead of another method; empty where that one was not run.
std::string Verdict(const ComparisonSummary& summary, const char* whose, const std::string& rival) {
  const MethodSummary* method = Find(summary, rival);
  if (method == nullptr || !method->difference) return "";
  const BootstrapInterval& d = *method->difference;
  const char* verdict = d.low > 0.0 ? "shown" : d.high < 0.0 ? "contradicted" : "not decided";
  return absl::StrFormat("%s: arcsine ahead of %s: %s (AUC %+.3f, 95 %% from %+.3f to %+.3f)",
                         whose, rival, verdict, d.mean, d.low, d.high);
}

}  // namespace

std::vector<std::string> CompareWithPaper(const ComparisonSummary& summary) {
  std::vector<std::string> lines;
  const MethodSummary* arcsine = Find(summary, "arcsine");
  if (arcsine == nullptr || arcsine != &summary.methods.front()) return lines;
  for (const char* rival : {"squared_exponential", "svm", "optical_flow", "ransac"}) {
    lines.push_back(Verdict(summary, "the paper's claim", rival));
  }
  for (const char* rival : {"labels", "dense_optical_flow", "homography_flow"}) {
    lines.push_back(Verdict(summary, "beyond the paper", rival));
  }
  lines.erase(std::remove(lines.begin(), lines.end(), ""), lines.end());
  if (arcsine->gain) {
    lines.push_back(
        absl::StrFormat("the paper's claim: improvement over time: AUC of the last third of a "
                        "drive less the first %+.3f (%s)",
                        *arcsine->gain, *arcsine->gain > 0.0 ? "as claimed" : "not shown"));
  }
  return lines;
}

PlotPage MakeComparisonPage(const std::vector<DriveComparison>& drives,
                            const ComparisonSummary& summary, const std::string& flags) {
  PlotPage page;
  page.title = "Egosieve and its rivals";
  page.paragraphs = {absl::StrFormat(
      "%d drives; the same features, labels, frames and pixels for every method. %s",
      summary.drives, flags)};
  for (const std::string& line : CompareWithPaper(summary)) {
    page.paragraphs.push_back(line);
  }
  page.table = ToTable(drives, summary);
  const std::vector<NamedScores> scores = Scores(summary);
  page.figures = {RocWithFeatures(summary),          AucAgainstFrame(drives, summary),
                  SizeAgainstFrame(drives, summary), DifferencesFigure(summary),
                  DrivesFigure(drives, summary),     TimeOfAFrame(summary),
                  PrecisionRecallFigure(scores),     IouByThresholdFigure(scores),
                  ReliabilityFigure(scores),         SparsificationFigure(scores)};
  return page;
}

}  // namespace egosieve::tools
