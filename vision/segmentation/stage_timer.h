// Adds the wall-clock time of its scope to a counter.
#pragma once

#include <chrono>

namespace egosieve::vision {

class StageTimer {
 public:
  explicit StageTimer(double& milliseconds)
      : milliseconds_(milliseconds), start_(std::chrono::steady_clock::now()) {}
  ~StageTimer() {
    milliseconds_ +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_)
            .count();
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double& milliseconds_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace egosieve::vision
