// Points like those of a street frame, seeded: six inputs in [-1, 1], objects as clusters in
// position and colour; one object in ten has high labels.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

struct StreetPoints {
  std::vector<double> inputs;  // n x 6
  std::vector<double> labels;

  kernels::ConstMatrixView<double> view() const {
    return {inputs.data(), static_cast<int64_t>(labels.size()), 6};
  }
  std::vector<double> targets() const {
    std::vector<double> y(labels);
    for (double& value : y) value = 2.0 * value - 1.0;
    return y;
  }
};

inline StreetPoints MakeStreetPoints(int64_t n, uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> normal;
  constexpr int kObjects = 40;
  double centres[kObjects][6];
  for (auto& centre : centres) {
    for (double& value : centre) value = 0.9 * uniform(generator);
  }
  StreetPoints points;
  for (int64_t i = 0; i < n; ++i) {
    const int object = static_cast<int>(generator() % kObjects);
    for (int d = 0; d < 6; ++d) {
      const double spread = d < 2 ? 0.15 : 0.1;
      points.inputs.push_back(
          std::clamp(centres[object][d] + spread * normal(generator), -1.0, 1.0));
    }
    const double p = (object % 10 == 0 ? 0.8 : 0.1) + 0.2 * normal(generator);
    points.labels.push_back(std::clamp(p, 0.0, 1.0));
  }
  return points;
}

// The device that the environment names; by default the best one.
inline std::shared_ptr<kernels::Context> BenchContext() {
  static const auto context = kernels::OpenContext();
  if (!context.ok()) std::abort();
  return *context;
}

}  // namespace egosieve::gp
