// The assignment of rows to columns with the largest total score: the Hungarian method with
// shortest augmenting paths (Kuhn, 1955; Jonker & Volgenant, 1987). Cost: O(rows^2 columns).
#ifndef EGOSIEVE_TOOLS_EVALUATION_ASSIGNMENT_H_
#define EGOSIEVE_TOOLS_EVALUATION_ASSIGNMENT_H_

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::tools {

// scores: finite and not negative. Gives each row's column, or -1. Every row or every column has a
// partner, whichever are fewer, but pairs with a score of 0 are not joined.
std::vector<int> AssignLargest(const cv::Mat1d& scores);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_ASSIGNMENT_H_
