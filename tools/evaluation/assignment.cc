#include "tools/evaluation/assignment.h"

#include <limits>

namespace egosieve::tools {
namespace {

// rows <= columns. Returns each column's row or -1. Costs are the negative scores.
std::vector<int> SolveWide(const cv::Mat1d& scores) {
  const int rows = scores.rows, columns = scores.cols;
  // Row and column 0 mean "none".
  std::vector<double> row_price(rows + 1, 0.0), column_price(columns + 1, 0.0);
  std::vector<int> row_of(columns + 1, 0), previous(columns + 1, 0);
  for (int row = 1; row <= rows; ++row) {
    std::vector<double> least(columns + 1, std::numeric_limits<double>::infinity());
    std::vector<bool> is_visited(columns + 1, false);
    int column = 0;
    row_of[0] = row;
    do {
      is_visited[column] = true;
      const int from = row_of[column];
      double step = std::numeric_limits<double>::infinity();
      int next = 0;
      for (int j = 1; j <= columns; ++j) {
        if (is_visited[j]) continue;
        const double reduced = -scores(from - 1, j - 1) - row_price[from] - column_price[j];
        if (reduced < least[j]) {
          least[j] = reduced;
          previous[j] = column;
        }
        if (least[j] < step) {
          step = least[j];
          next = j;
        }
      }
      for (int j = 0; j <= columns; ++j) {
        if (is_visited[j]) {
          row_price[row_of[j]] += step;
          column_price[j] -= step;
        } else {
          least[j] -= step;
        }
      }
      column = next;
    } while (row_of[column] != 0);
    for (; column != 0; column = previous[column]) row_of[column] = row_of[previous[column]];
  }
  std::vector<int> result(columns);
  for (int j = 0; j < columns; ++j) result[j] = row_of[j + 1] - 1;
  return result;
}

}  // namespace

std::vector<int> AssignLargest(const cv::Mat1d& scores) {
  std::vector<int> column_of(scores.rows, -1);
  if (scores.empty()) return column_of;
  if (scores.rows <= scores.cols) {
    const std::vector<int> row_of = SolveWide(scores);
    for (int column = 0; column < scores.cols; ++column) {
      if (row_of[column] >= 0) column_of[row_of[column]] = column;
    }
  } else {
    column_of = SolveWide(scores.t());
  }
  for (int row = 0; row < scores.rows; ++row) {
    if (column_of[row] >= 0 && !(scores(row, column_of[row]) > 0.0)) column_of[row] = -1;
  }
  return column_of;
}

}  // namespace egosieve::tools
