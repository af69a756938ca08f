// Figures that follow from scores (drive_scores.h) alone; several scores in one figure.
#ifndef EGOSIEVE_TOOLS_PLOTS_SCORE_FIGURES_H_
#define EGOSIEVE_TOOLS_PLOTS_SCORE_FIGURES_H_

#include <string>
#include <vector>

#include "tools/evaluation/drive_scores.h"
#include "tools/plots/figure.h"

namespace egosieve::tools {

struct NamedScores {
  std::string name;
  const DriveScores* scores = nullptr;
  bool probabilistic = true;  // else it has no reliability diagram
};

// The ROC curve of a histogram, for figures of the functions below.
Series RocSeries(const std::string& name, const RocHistogram& scores);

Figure RocFigure(const std::vector<NamedScores>& all);
Figure PrecisionRecallFigure(const std::vector<NamedScores>& all);
Figure ReliabilityFigure(const std::vector<NamedScores>& all);
Figure SparsificationFigure(const std::vector<NamedScores>& all);
Figure IouByThresholdFigure(const std::vector<NamedScores>& all);
Figure AucByFrameFigure(const std::vector<NamedScores>& all);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_PLOTS_SCORE_FIGURES_H_
