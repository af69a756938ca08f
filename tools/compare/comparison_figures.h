// The paper's figures 2e, 4a and 4b for a comparison, and what belongs beside them.
#ifndef EGOSIEVE_TOOLS_COMPARE_COMPARISON_FIGURES_H_
#define EGOSIEVE_TOOLS_COMPARE_COMPARISON_FIGURES_H_

#include <vector>

#include "tools/compare/comparison_table.h"
#include "tools/plots/plot_page.h"

namespace egosieve::tools {

PlotPage MakeComparisonPage(const std::vector<DriveComparison>& drives,
                            const ComparisonSummary& summary, const std::string& flags);

// What the paper claims and these figures do or do not show, a sentence each.
std::vector<std::string> CompareWithPaper(const ComparisonSummary& summary);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_COMPARE_COMPARISON_FIGURES_H_
