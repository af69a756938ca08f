// The paper's figures 2e, 4a and 4b for a comparison, and related ones: one page with each figure
// once per profile.
#ifndef EGOSIEVE_TOOLS_LAB_COMPARE_COMPARISON_FIGURES_H_
#define EGOSIEVE_TOOLS_LAB_COMPARE_COMPARISON_FIGURES_H_

#include <vector>

#include "tools/lab/compare/profile_comparison.h"
#include "tools/plots/plot_page.h"

namespace egosieve::tools {

// Profiles in which every drive failed have no figures.
PlotPage MakeComparisonPage(const std::vector<ProfileComparison>& profiles);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_COMPARE_COMPARISON_FIGURES_H_
