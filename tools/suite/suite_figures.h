// A suite's results as figures.
#ifndef EGOSIEVE_TOOLS_SUITE_SUITE_FIGURES_H_
#define EGOSIEVE_TOOLS_SUITE_SUITE_FIGURES_H_

#include <vector>

#include "tools/plots/plot_page.h"
#include "tools/suite/suite_table.h"

namespace egosieve::tools {

PlotPage MakeSuitePage(const SequenceList& list, const std::vector<SequenceResult>& results,
                       const SuiteSummary& summary);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SUITE_SUITE_FIGURES_H_
