// Figures from a suite's further truth, beside masks and tracks (further_truth.h): boxes, pooled
// over the sequences of a variant; trajectory, lens and own vehicle, one line per sequence.
#ifndef EGOSIEVE_TOOLS_SUITE_FURTHER_TABLE_H_
#define EGOSIEVE_TOOLS_SUITE_FURTHER_TABLE_H_

#include <string>
#include <vector>

#include "tools/suite/suite_run.h"

namespace egosieve::tools {

// Empty if no sequence has further truth.
std::string FurtherTable(const std::vector<SequenceResult>& results);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SUITE_FURTHER_TABLE_H_
