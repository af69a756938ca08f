// Comparisons whose figures are known by hand.
#ifndef EGOSIEVE_TESTS_TOOLS_LAB_COMPARE_MADE_COMPARISON_H_
#define EGOSIEVE_TESTS_TOOLS_LAB_COMPARE_MADE_COMPARISON_H_

#include <string>
#include <vector>

#include "tools/lab/compare/drive_comparison.h"

namespace egosieve::tools {

// A frame for each AUC given, in hundredths: one mover against a hundred static pixels, of which
// that share lies below it. Model sizes are 0, 10, 20, ..., own times 5, 6, 7, ... ms.
MethodResult MakeMethodResult(const std::string& name, const std::vector<double>& aucs);

// Methods "arcsine" and another; shared times are 100 ms.
DriveComparison MakeDrive(const std::string& name, const std::vector<double>& first,
                          const std::vector<double>& second, const std::string& rival = "svm");

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TESTS_TOOLS_LAB_COMPARE_MADE_COMPARISON_H_
