// Prepares points (kernels/base/prepared_points.h) on the device, from and to the device's memory.
//
// On an H200 (4.8 TB/s, 132 units of 2,048 work-items), counted, not measured: for 465,750 queries
// with D = 6 the arcsine's preparation reads 24 and writes 32 bytes each, 26 MB, 0.005 ms, and has
// some 30 operations in float64 each; with one work-item per query the units are filled 1.7 times.
#pragma once

#include <CL/opencl.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/prepared_points.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

// Elements of a matrix of points in a buffer.
struct PointsAt {
  cl::Buffer memory;
  int64_t first = 0;   // element where the first point begins
  int64_t stride = 0;  // elements from one point to the next
  int64_t count = 0;
};

// The place of prepared points: value c of point i is element c component_step + i point_step.
// Points from the count to padded_count are zeros.
struct PreparedAt {
  cl::Buffer buffer;
  int64_t component_step = 1;
  int64_t point_step = 1;
  int64_t padded_count = 0;
};

class DevicePreparation {
 public:
  // Throws cl::Error.
  DevicePreparation(const Context& context, const CovarianceParameters& parameters,
                    const PointPreparation& preparation);

  // The kernel from points of type T, float or double, to prepared ones of the same type.
  // FailedPrecondition on devices without float64.
  template <typename T>
  absl::StatusOr<cl::Kernel> Kernel(const Context& context, Workspace& workspace) const;
  // Throws cl::Error.
  cl::Event Enqueue(cl::Kernel& kernel, const cl::CommandQueue& queue, const PointsAt& points,
                    const PreparedAt& out, const std::vector<cl::Event>& after) const;

 private:
  std::string code_;
  std::vector<double> scales_and_centre_;  // devices that share host memory read it in place
  cl::Buffer buffer_;
};

}  // namespace egosieve::kernels::opencl
