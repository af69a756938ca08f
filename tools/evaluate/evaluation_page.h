// Figures of one run's evaluation.
#ifndef EGOSIEVE_TOOLS_EVALUATE_EVALUATION_PAGE_H_
#define EGOSIEVE_TOOLS_EVALUATE_EVALUATION_PAGE_H_

#include "tools/evaluate/evaluate_run.h"
#include "tools/plots/plot_page.h"

namespace egosieve::tools {

PlotPage MakeEvaluationPage(const RunEvaluation& run);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_EVALUATION_PAGE_H_
