// What the suite's sequences know beside masks and tracks (further_truth.h): boxes, pooled over the
// sequences of a variant; trajectory, lens and own vehicle, a line a sequence.
#ifndef EGOSIEVE_TOOLS_SUITE_FURTHER_TABLE_H_
#define EGOSIEVE_TOOLS_SUITE_FURTHER_TABLE_H_

#include <string>
#include <vector>

#include "tools/suite/suite_run.h"

namespace egosieve::tools {

// Empty where no sequence knows more.
std::string FurtherTable(const std::vector<SequenceResult>& results);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SUITE_FURTHER_TABLE_H_
