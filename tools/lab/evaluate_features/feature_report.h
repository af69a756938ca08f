// Scores of several sequences as a table for people and as JSON for programs.
#ifndef EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_FEATURE_REPORT_H_
#define EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_FEATURE_REPORT_H_

#include <string>
#include <vector>

#include "tools/lab/evaluate_features/evaluate_features.h"

namespace egosieve::tools {

// One line per sequence, one line for all (means over sequences, sums of counts), and the rule by
// which the choice of motion model was judged. A missing AUC is "-".
std::string ToTable(const std::vector<SequenceScore>& scores);

// {"sequences": [{"name", "residual_auc", ..., "frames": [...]}], "all": {...}}; a missing AUC is
// null.
std::string ToJson(const std::vector<SequenceScore>& scores,
                   const EvaluateFeaturesOptions& options);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_FEATURE_REPORT_H_
