#include "tools/report/chart.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"

namespace egosieve::tools {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

using Field = std::function<double(const FrameLine&)>;

class ChartBuilder {
 public:
  ChartBuilder(absl::Span<const FrameLine> lines, int64_t max_points)
      : lines_(lines),
        frames_per_point_((static_cast<int64_t>(lines.size()) + max_points - 1) / max_points) {}

  int64_t frames_per_point() const { return frames_per_point_; }

  void AddSeries(const std::string& name, const Field& field, Chart& chart) const {
    std::vector<double> x, values;
    for (size_t begin = 0; begin < lines_.size(); begin += frames_per_point_) {
      double sum = 0.0;
      int64_t count = 0;
      for (const FrameLine& line : lines_.subspan(begin, frames_per_point_)) {
        if (const double value = field(line); std::isfinite(value)) {
          sum += value;
          ++count;
        }
      }
      x.push_back(static_cast<double>(lines_[begin].index));
      values.push_back(count > 0 ? sum / static_cast<double>(count) : kNone);
    }
    chart.x = std::move(x);
    chart.series.push_back(name);
    chart.values.push_back(std::move(values));
  }

 private:
  absl::Span<const FrameLine> lines_;
  int64_t frames_per_point_;
};

Field Count(int64_t FrameLine::*member) {
  return [member](const FrameLine& line) { return static_cast<double>(line.*member); };
}

Field PointCount(int64_t vision::SelectionCounts::*member) {
  return [member](const FrameLine& line) { return static_cast<double>(line.points.*member); };
}

bool Learnt(const FrameLine& line) { return line.outcome == FrameLine::Outcome::kLearnt; }

Chart ModelSizeChart(const ChartBuilder& builder) {
  Chart chart{"modelsize", "Model size",
              "Training points of the Gaussian process after each frame.", "points"};
  builder.AddSeries("model size", Count(&FrameLine::model_size), chart);
  return chart;
}

Chart StagesChart(const ChartBuilder& builder, absl::Span<const FrameLine> lines) {
  Chart chart{
      "stages", "Time by stage",
      "Milliseconds per frame, one stage on top of the other. The axis is cut where 98 % of the "
      "frames lie.",
      "ms"};
  chart.stacked = true;
  std::vector<std::string> stages;
  for (const FrameLine& line : lines) {
    for (const auto& [stage, milliseconds] : line.milliseconds) {
      if (std::find(stages.begin(), stages.end(), stage) == stages.end()) {
        stages.push_back(stage);
      }
    }
  }
  for (const std::string& name : stages) {
    builder.AddSeries(
        name,
        [&name](const FrameLine& line) {
          for (const auto& [stage, milliseconds] : line.milliseconds) {
            if (stage == name) return milliseconds;
          }
          return 0.0;
        },
        chart);
  }
  return chart;
}

Chart DynamicShareChart(const ChartBuilder& builder) {
  Chart chart{"share", "Dynamic share",
              "Percentage of the grid's pixels whose probability of moving is 1/2 or more.", "%"};
  builder.AddSeries(
      "dynamic share",
      [](const FrameLine& line) {
        return line.model_size > 0 && line.has_map() ? 100.0 * line.dynamic_share : kNone;
      },
      chart);
  return chart;
}

Chart LabelsChart(const ChartBuilder& builder) {
  Chart chart{"labels", "Matches and labels",
              "Matched features, inliers of the camera's motion, and the labels made from them.",
              "features"};
  builder.AddSeries("matches", Count(&FrameLine::matches), chart);
  builder.AddSeries("inliers", Count(&FrameLine::inliers), chart);
  builder.AddSeries("static labels", Count(&FrameLine::labelled_static), chart);
  builder.AddSeries("dynamic labels", Count(&FrameLine::labelled_dynamic), chart);
  return chart;
}

Chart EvidenceChart(const ChartBuilder& builder, absl::Span<const FrameLine> lines) {
  Chart chart{"evidence", "Evidence",
              "Percentage of the dynamic labels by the evidence that weighed most: distance to the "
              "epipolar line or homography, depth behind the camera, third view, road.",
              "%"};
  chart.stacked = true;
  std::vector<std::string> terms;
  for (const FrameLine& line : lines) {
    if (line.decided_by.size() <= terms.size()) continue;
    terms.clear();
    for (const auto& [term, share] : line.decided_by) terms.push_back(term);
  }
  for (size_t k = 0; k < terms.size(); ++k) {
    builder.AddSeries(
        terms[k],
        [k](const FrameLine& line) {
          return k < line.decided_by.size() ? 100.0 * line.decided_by[k].second : kNone;
        },
        chart);
  }
  return chart;
}

Chart NewPointsChart(const ChartBuilder& builder) {
  using Points = vision::SelectionCounts;
  Chart chart{"newpoints", "New points",
              "A frame's labelled features, those that the filters dropped, and those that the "
              "model took.",
              "points"};
  builder.AddSeries("candidates", PointCount(&Points::candidates), chart);
  builder.AddSeries("dropped: density", PointCount(&Points::dropped_by_density), chart);
  builder.AddSeries("dropped: novelty", PointCount(&Points::dropped_by_novelty), chart);
  builder.AddSeries("added", PointCount(&Points::added), chart);
  return chart;
}

Chart DroppedPointsChart(const ChartBuilder& builder) {
  using Points = vision::SelectionCounts;
  Chart chart{"droppedpoints", "Points that left the model",
              "Points per frame, by the filter that dropped them.", "points"};
  builder.AddSeries("consistency", PointCount(&Points::dropped_by_consistency), chart);
  builder.AddSeries("density", PointCount(&Points::dropped_by_model_density), chart);
  builder.AddSeries("age", PointCount(&Points::dropped_by_age), chart);
  builder.AddSeries("budget", PointCount(&Points::dropped_by_budget), chart);
  return chart;
}

// Where in a drive nothing was learnt; the page's table gives the reasons.
Chart OutcomeChart(const ChartBuilder& builder) {
  Chart chart{"outcome", "Frames by outcome",
              "Percentage of the frames that were learnt from, that have a map and were not learnt "
              "from, and that could not be read.",
              "%"};
  chart.stacked = true;
  for (const auto& [name, outcome] : {std::pair("learnt from", FrameLine::Outcome::kLearnt),
                                      std::pair("not learnt from", FrameLine::Outcome::kAnswered),
                                      std::pair("failed", FrameLine::Outcome::kFailed)}) {
    builder.AddSeries(
        name,
        [outcome = outcome](const FrameLine& line) {
          return line.outcome == outcome ? 100.0 : 0.0;
        },
        chart);
  }
  return chart;
}

Chart LikelihoodChart(const ChartBuilder& builder) {
  Chart chart{"likelihood", "Log marginal likelihood",
              "Of the training subset, in nats per point, in the frames that trained.",
              "nats / point"};
  chart.from_zero = false;
  builder.AddSeries(
      "log likelihood",
      [](const FrameLine& line) {
        return Learnt(line) && line.log_likelihood_per_point != 0.0 ? line.log_likelihood_per_point
                                                                    : kNone;
      },
      chart);
  return chart;
}

// The names of theta's values: D + 3 for the arcsine over the six inputs, D + 2 for the squared
// exponential.
std::vector<std::string> ThetaNames(size_t size) {
  std::vector<std::string> names;
  if (size == 9) {
    names = {"w bias", "w u", "w v", "w M", "w R", "w G", "w B"};
  } else if (size == 8) {
    names = {"l u", "l v", "l M", "l R", "l G", "l B"};
  } else {
    for (size_t i = 0; i + 2 < size; ++i) names.push_back(absl::StrCat("scale ", i));
  }
  if (size >= 2) {
    names.insert(names.end(), {"sigma f", "sigma n"});
  }
  return names;
}

Chart ThetaChart(const ChartBuilder& builder, absl::Span<const FrameLine> lines) {
  Chart chart{"theta", "Hyperparameters",
              "Natural logarithms: the covariance's scale of each input, its amplitude, the noise.",
              "log"};
  chart.from_zero = false;
  size_t size = 0;
  for (const FrameLine& line : lines) {
    size = std::max(size, line.theta.size());
  }
  const std::vector<std::string> names = ThetaNames(size);
  for (size_t i = 0; i < names.size(); ++i) {
    builder.AddSeries(
        names[i],
        [i](const FrameLine& line) { return i < line.theta.size() ? line.theta[i] : kNone; },
        chart);
  }
  return chart;
}

Chart CalibrationChart(const ChartBuilder& builder) {
  Chart chart{"calibration", "Calibration",
              "a and b of p = \u03a6((a mean + b) / sqrt(1 + a\u00b2 variance)).", ""};
  chart.from_zero = false;
  builder.AddSeries(
      "a", [](const FrameLine& line) { return line.a; }, chart);
  builder.AddSeries(
      "b", [](const FrameLine& line) { return line.b; }, chart);
  return chart;
}

Chart AucChart(const EvaluationFile& evaluation, int64_t max_points) {
  Chart chart{"auc", "Area under the ROC curve",
              "Against the truth, frame by frame; frames whose truth has one class have none.",
              "AUC"};
  chart.from_zero = false;
  // The evaluated frames as lines, to be averaged like the others.
  std::vector<FrameLine> lines;
  for (const EvaluatedFrame& frame : evaluation.frames) {
    lines.emplace_back();
    lines.back().index = frame.index;
    lines.back().dynamic_share = frame.auc;
  }
  ChartBuilder(lines, max_points)
      .AddSeries(
          "AUC", [](const FrameLine& line) { return line.dynamic_share; }, chart);
  return chart;
}

bool HasPoint(const Chart& chart) {
  for (const std::vector<double>& row : chart.values) {
    if (std::any_of(row.begin(), row.end(), [](double value) { return std::isfinite(value); })) {
      return true;
    }
  }
  return false;
}

}  // namespace

std::vector<Chart> MakeCharts(absl::Span<const FrameLine> lines,
                              const std::optional<EvaluationFile>& evaluation, int64_t max_points) {
  const ChartBuilder builder(lines, max_points);
  std::vector<Chart> charts;
  if (evaluation) {
    charts.push_back(AucChart(*evaluation, max_points));
  }
  charts.push_back(DynamicShareChart(builder));
  charts.push_back(ModelSizeChart(builder));
  charts.push_back(StagesChart(builder, lines));
  charts.push_back(LabelsChart(builder));
  charts.push_back(EvidenceChart(builder, lines));
  charts.push_back(NewPointsChart(builder));
  charts.push_back(DroppedPointsChart(builder));
  charts.push_back(LikelihoodChart(builder));
  charts.push_back(ThetaChart(builder, lines));
  charts.push_back(CalibrationChart(builder));
  charts.push_back(OutcomeChart(builder));
  charts.erase(std::remove_if(charts.begin(), charts.end(),
                              [](const Chart& chart) { return !HasPoint(chart); }),
               charts.end());
  if (builder.frames_per_point() > 1) {
    for (Chart& chart : charts) {
      absl::StrAppend(&chart.caption, " Each point is the mean of ", builder.frames_per_point(),
                      " frames.");
    }
  }
  return charts;
}

nlohmann::ordered_json ToJson(const Chart& chart) {
  return {{"id", chart.id},           {"unit", chart.unit},
          {"stacked", chart.stacked}, {"from_zero", chart.from_zero},
          {"series", chart.series},   {"x", chart.x},
          {"values", chart.values}};
}

}  // namespace egosieve::tools
