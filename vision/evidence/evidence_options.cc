#include "vision/evidence/evidence_options.h"

#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {

absl::Status EvidenceOptions::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(kernels::CheckOptions({
      {"focal_pixels", focal_pixels, kernels::IsNotNegative(focal_pixels), "not be negative"},
      {"forgetting", forgetting, forgetting >= 0 && forgetting < 1, "lie in [0, 1)"},
      {"tempering", tempering, tempering > 0 && tempering <= 1, "lie in (0, 1]"},
      {"noise_memory", noise_memory, noise_memory >= 0 && noise_memory < 1, "lie in [0, 1)"},
      {"noise_floor_pixels", noise_floor_pixels, kernels::IsPositive(noise_floor_pixels),
       "be positive"},
  }));
  return pose.Validate();
}

}  // namespace egosieve::vision
