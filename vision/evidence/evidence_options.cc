#include "vision/evidence/evidence_options.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

// Checks one option. rule: the condition `holds` in words.
absl::Status Check(const char* name, double value, bool holds, const char* rule) {
  if (holds && std::isfinite(value)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(name, " is ", value, "; it must ", rule));
}

}  // namespace

absl::Status EvidenceOptions::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(
      Check("focal_pixels", focal_pixels, focal_pixels >= 0, "not be negative"));
  EGOSIEVE_RETURN_IF_ERROR(
      Check("forgetting", forgetting, forgetting >= 0 && forgetting < 1, "lie in [0, 1)"));
  EGOSIEVE_RETURN_IF_ERROR(
      Check("tempering", tempering, tempering > 0 && tempering <= 1, "lie in (0, 1]"));
  EGOSIEVE_RETURN_IF_ERROR(
      Check("noise_memory", noise_memory, noise_memory >= 0 && noise_memory < 1, "lie in [0, 1)"));
  EGOSIEVE_RETURN_IF_ERROR(
      Check("noise_floor_pixels", noise_floor_pixels, noise_floor_pixels > 0, "be positive"));
  EGOSIEVE_RETURN_IF_ERROR(pose.Validate());
  EGOSIEVE_RETURN_IF_ERROR(three_views.Validate());
  return own_vehicle_options.Validate();
}

}  // namespace egosieve::vision
