// Functions that are no compositions: their device code is a text.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/covariance/covariance_function.h"

namespace egosieve::kernels {

// The first line of prepare_point, open.
inline constexpr char kPreparationHead[] = R"(
static inline void prepare_point@(const double* scales, const double* x, const double* centre, double* point) {
)";

// Device code for functions with f(x, x) = 1.
inline constexpr char kUnitVarianceCode[] = R"(
static inline float unit_variance@(__global const float* point, const long stride) { return 1.0f; }
)";

class Elementary : public CovarianceDescription {
 public:
  // Unless a function says otherwise.
  double Variance(const double* /*scales*/, int64_t /*dimension*/,
                  const double* /*x*/) const override {
    return 1.0;
  }

  std::string DeviceCode(const DeviceCodeRequest& request) const override {
    return WithSuffix(device_code_, request);
  }
  std::string PreparationCode(const DeviceCodeRequest& request) const override {
    return WithSuffix(absl::StrCat(before_preparation_, kPreparationHead, preparation_, "}\n"),
                      request);
  }

 protected:
  // preparation: the lines of prepare_point; before_preparation: functions that it calls.
  Elementary(std::vector<ScaleGroup> groups, std::string device_code, std::string preparation,
             std::string before_preparation = "")
      : CovarianceDescription(std::move(groups)),
        device_code_(std::move(device_code)),
        preparation_(std::move(preparation)),
        before_preparation_(std::move(before_preparation)) {}

 private:
  std::string device_code_, preparation_, before_preparation_;
};

// Functions without scales, constant wherever they are smooth, so that all gradients are 0.
class Scaleless : public Elementary {
 public:
  Scaleless(std::string device_code, std::string preparation)
      : Elementary({}, std::move(device_code), std::move(preparation)) {}

  void AddGradient(int64_t /*dimension*/, const double* /*a*/, const double* /*b*/,
                   double /*weight*/, double* /*gradient*/) const override {}
  void AddInputGradient(const double* /*scales*/, int64_t /*dimension*/, const double* /*a*/,
                        const double* /*b*/, double /*weight*/,
                        double* /*gradient*/) const override {}
};

}  // namespace egosieve::kernels
