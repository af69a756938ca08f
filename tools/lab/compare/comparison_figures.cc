#include "tools/lab/compare/comparison_figures.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "tools/plots/score_figures.h"

namespace egosieve::tools {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kSmoothing = 4;  // on either side

std::vector<NamedScores> Scores(const ComparisonSummary& summary) {
  std::vector<NamedScores> all;
  for (const MethodSummary& method : summary.methods) {
    all.push_back({method.method, &method.scores, method.probabilistic});
  }
  return all;
}

// Mean over drives of each drive's value at a frame's position in the drive.
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

// A moving mean, so that nine methods can be distinguished.
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
  Figure figure{"time", "Time per frame",
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

// One interval per method that has it, times `unit`.
void AddIntervals(const char* name, std::optional<BootstrapInterval> MethodSummary::*interval,
                  double unit, const ComparisonSummary& summary, Figure& figure) {
  Series series{name, {}, {}};
  series.style = Series::Style::kIntervals;
  for (const MethodSummary& method : summary.methods) {
    if (!(method.*interval)) continue;
    const BootstrapInterval& known = *(method.*interval);
    series.x.push_back(static_cast<double>(figure.categories.size()));
    series.y.push_back(unit * known.mean);
    series.low.push_back(unit * known.low);
    series.high.push_back(unit * known.high);
    figure.categories.push_back(method.method);
  }
  figure.series.push_back(std::move(series));
}

Figure DifferencesFigure(const ComparisonSummary& summary) {
  const std::string first = summary.methods.empty() ? "" : summary.methods.front().method;
  Figure figure{
      "differences", absl::StrCat("AUC of ", first, " less that of each method"),
      "Mean difference over frames, with the interval that holds 95 % of the block "
      "bootstrap's resamples. Above 0: the first method is better; an interval that holds "
      "0 decides nothing.",
      "", "difference in AUC"};
  AddIntervals("difference", &MethodSummary::difference, 1.0, summary, figure);
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

Figure TrendsFigure(const ComparisonSummary& summary) {
  constexpr double kFrames = 100.0;
  Figure figure{"trends", "AUC gained over time",
                "Slope of the AUC of single frames over their number, common to all drives, with "
                "the interval that holds 95 % of the block bootstrap's resamples; an interval that "
                "holds 0 decides nothing. What methods that learn nothing gain, too, is the "
                "drives' getting easier.",
                "", "AUC gained in 100 frames"};
  AddIntervals("slope", &MethodSummary::slope, kFrames, summary, figure);
  return figure;
}

Figure ProfilesFigure(const std::vector<ProfileComparison>& profiles) {
  Figure figure{"profiles", "AUC by method and profile",
                "Mean over all frames of all drives of the area under the ROC curve; 0.5 is "
                "guessing.",
                "", "AUC"};
  for (const ProfileComparison& profile : profiles) {
    Series series{profile.profile, {}, {}};
    series.style = Series::Style::kBars;
    for (const MethodSummary& method : profile.summary.methods) {
      const auto known =
          std::find(figure.categories.begin(), figure.categories.end(), method.method);
      series.x.push_back(static_cast<double>(known - figure.categories.begin()));
      series.y.push_back(method.frame_auc.value_or(kNone));
      if (known == figure.categories.end()) figure.categories.push_back(method.method);
    }
    if (!series.x.empty()) figure.series.push_back(std::move(series));
  }
  figure.y_range = std::pair(0.0, 1.0);
  figure.full_width = true;
  return figure;
}

// All figures of one profile, in the order of the page.
std::vector<Figure> FiguresOf(const ProfileComparison& profile) {
  const std::vector<DriveComparison>& drives = profile.drives;
  const ComparisonSummary& summary = profile.summary;
  const std::vector<NamedScores> scores = Scores(summary);
  return {RocWithFeatures(summary),     AucAgainstFrame(drives, summary),
          TrendsFigure(summary),        SizeAgainstFrame(drives, summary),
          DifferencesFigure(summary),   DrivesFigure(drives, summary),
          TimeOfAFrame(summary),        PrecisionRecallFigure(scores),
          IouByThresholdFigure(scores), ReliabilityFigure(scores),
          SparsificationFigure(scores)};
}

}  // namespace

PlotPage MakeComparisonPage(const std::vector<ProfileComparison>& profiles) {
  PlotPage page;
  page.title = "Egosieve and other methods";
  page.table = ToTable(profiles);
  const bool several = profiles.size() > 1;
  std::vector<std::vector<Figure>> figures;
  page.columns = std::max<int>(1, static_cast<int>(profiles.size()));
  for (const ProfileComparison& profile : profiles) {
    TextList claims{absl::StrFormat("Profile %s: what the paper claims, and what %d drives show",
                                    profile.profile, profile.summary.drives),
                    CompareWithPaper(profile.summary)};
    claims.items.push_back(
        absl::StrFormat("flags: %s; the same features, labels, frames and pixels for every method",
                        absl::StrJoin(profile.flags, ", ", absl::PairFormatter(" "))));
    page.lists.push_back(std::move(claims));
    if (profile.summary.drives == 0) continue;
    figures.push_back(FiguresOf(profile));
    for (Figure& figure : figures.back()) {
      if (!several) break;
      absl::StrAppend(&figure.id, "_",
                      absl::StrReplaceAll(profile.profile, {{"-", "_"}, {"+", "_and_"}}));
      absl::StrAppend(&figure.title, ", profile ", profile.profile);
    }
  }
  if (several) page.figures.push_back(ProfilesFigure(profiles));
  for (size_t kind = 0; !figures.empty() && kind < figures.front().size(); ++kind) {
    for (std::vector<Figure>& all : figures) page.figures.push_back(std::move(all[kind]));
  }
  return page;
}

}  // namespace egosieve::tools
