// Time of the stages of a computation that follow each other: a lap for each, in milliseconds of a
// clock that is never set back.
#pragma once

#include <chrono>

namespace egosieve::vision {

class Stopwatch {
 public:
  // Since the last call, or since construction.
  double LapMilliseconds() {
    const auto now = std::chrono::steady_clock::now();
    const std::chrono::duration<double, std::milli> lap = now - start_;
    start_ = now;
    return lap.count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace egosieve::vision
