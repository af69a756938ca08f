// A posterior's model in the device's memory, as the kernels read it.
#pragma once

#include <CL/opencl.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/base/aligned_array.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/posterior_model.h"
#include "kernels/base/prepared_points.h"
#include "kernels/ops/packed_factor.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

class DeviceModel {
 public:
  // Throws cl::Error. The views of `model` are read here only.
  DeviceModel(const Context& context, const PosteriorModel& model, const FactorBlocking& blocking);
  DeviceModel(const DeviceModel&) = delete;
  DeviceModel& operator=(const DeviceModel&) = delete;

  const CovarianceParameters& covariance() const { return covariance_; }
  FactorKind factor_kind() const { return factor_kind_; }
  float squash_a() const { return squash_a_; }
  float squash_b() const { return squash_b_; }
  int64_t count() const { return count_; }  // n
  const PointPreparation& preparation() const { return preparation_; }
  const std::string& covariance_code() const { return code_; }
  const std::string& note() const { return note_; }
  const cl::Buffer& inputs() const { return inputs_; }
  const cl::Buffer& alpha() const { return alpha_; }
  const cl::Buffer& factor() const { return factor_; }

 private:
  // The arrays for the kernel, prepared on the host. Kept, because a device that shares the host's
  // memory reads them in place.
  struct HostArrays {
    std::vector<float> inputs;  // prepared points
    std::vector<float> alpha;   // sigma_f^2 alpha
    AlignedArray<float> factor;
  };

  CovarianceParameters covariance_;
  FactorKind factor_kind_;
  float squash_a_;
  float squash_b_;
  int64_t count_;
  PointPreparation preparation_;
  std::string code_;
  std::string note_;
  HostArrays host_;
  cl::Buffer inputs_;
  cl::Buffer alpha_;
  cl::Buffer factor_;
};

}  // namespace egosieve::kernels::opencl
