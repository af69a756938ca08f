// A posterior's model in the device's memory, as the kernels read it.
//
// The triangular factor of a posterior in the order of the kernel's reads, float32.
//
// Rows are divided into groups of `group` and, inside a group, into panels of `panel`; n is padded
// to a multiple of the panel with rows and columns of zeros. A group that starts at row f with c
// rows contains
//
//   (1) left of its diagonal block: for each range of `depth` columns k, for each panel, for each
//       k, `panel` values;
//   (2) of its diagonal block's lower triangle: for each panel p, for each k < panel (p + 1),
//       `panel` values.
//
// For R (the product, variance = k** - |R k*|^2) these are the elements of R. For L (substitution),
// with L_gg the diagonal block of group g, they are
//
//   (3) v_g = L_gg^-1 (k*_g - sum_{h<g} L_gh v_h):
//       (1) holds -L_gh, (2) holds L_gg^-1, inverted in float64
//
// so both use the same multiply-add kernel, and no inverse of the whole factor is formed. Cost of
// packing L: n^2 / 2 + n group^2 / 6 multiply-adds.
#pragma once

#include <CL/opencl.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/base/aligned_array.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/posterior_model.h"
#include "kernels/base/prepared_points.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

struct FactorBlocking {
  int panel = 8;
  int group = 96;  // a multiple of panel
  int depth = 192;
};

inline int64_t PaddedCount(int64_t n, int panel) { return (n + panel - 1) / panel * panel; }

struct DeviceModel {
  // Throws cl::Error. The views of `model` are read here only.
  DeviceModel(const Context& context, const PosteriorModel& model, const FactorBlocking& blocking);
  DeviceModel(const DeviceModel&) = delete;
  DeviceModel& operator=(const DeviceModel&) = delete;

  const CovarianceParameters covariance;
  const FactorKind factor_kind;
  const float squash_a, squash_b;
  const int64_t count;  // n
  const PointPreparation preparation;
  std::string covariance_code;
  cl::Buffer inputs, alpha, factor;

  // The arrays for the kernel, prepared on the host. Kept, because a device that shares the host's
  // memory reads them in place.
  struct HostArrays {
    std::vector<float> inputs;  // prepared points
    std::vector<float> alpha;   // sigma_f^2 alpha
    AlignedArray<float> factor;
  } host;
};

}  // namespace egosieve::kernels::opencl
