#include "tools/evaluate/evaluation_page.h"

#include "absl/strings/str_cat.h"
#include "tools/plots/score_figures.h"

namespace egosieve::tools {

PlotPage MakeEvaluationPage(const RunEvaluation& run) {
  const Evaluation& evaluation = run.evaluation;
  PlotPage page;
  page.title = "Evaluation of a run";
  page.paragraphs = {absl::StrCat("Scored against ", evaluation.truth, " (", evaluation.truth_kind,
                                  ", matched by ", evaluation.matched_by, "); pixels: ",
                                  evaluation.pixels, "; ", evaluation.frames.size(), " frames.")};
  page.table = ToTable(evaluation);
  const std::vector<NamedScores> scores = {{"map", &run.scores}};
  page.figures = {RocFigure(scores),         PrecisionRecallFigure(scores),
                  AucByFrameFigure(scores),  IouByThresholdFigure(scores),
                  ReliabilityFigure(scores), SparsificationFigure(scores)};
  return page;
}

}  // namespace egosieve::tools
