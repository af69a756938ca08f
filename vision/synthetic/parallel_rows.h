// Runs body(row) for every row in [0, rows) on `threads` threads. Rows are handed out as threads
// get free, so results must not depend on the order.
#ifndef EGOSIEVE_VISION_SYNTHETIC_PARALLEL_ROWS_H_
#define EGOSIEVE_VISION_SYNTHETIC_PARALLEL_ROWS_H_

#include <atomic>
#include <thread>
#include <vector>

namespace egosieve::vision {

template <typename Body>
void ParallelRows(int rows, int threads, const Body& body) {
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int row = next++; row < rows; row = next++) body(row);
  };
  std::vector<std::thread> helpers;
  for (int k = 1; k < threads; ++k) helpers.emplace_back(work);
  work();
  for (std::thread& helper : helpers) helper.join();
}

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SYNTHETIC_PARALLEL_ROWS_H_
