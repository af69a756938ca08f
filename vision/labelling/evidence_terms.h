// The terms of evidence that labels use. Each is computed in vision/evidence; here they are named,
// selected and described as text.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::vision {

struct EvidenceTerms {
  bool epipolar = true;        // distance to the motion model, of any kind
  bool negative_depth = true;  // cheirality: flow towards the point of expansion
  bool road = true;            // below the road, or at a depth that disagrees with ground contact
  bool accumulation = true;    // sums along tracks

  static EvidenceTerms EpipolarAlone() { return {true, false, false, false}; }

  // Whether a term that detects movers is selected; the last only modifies the others.
  bool IsEnough() const { return epipolar || negative_depth || road; }
};

// "all", or the fields' names in their order, joined by commas.
std::string Describe(const EvidenceTerms& terms);
// Accepts the names in any order. InvalidArgument, listing the names, for other text, or if
// IsEnough() is false.
absl::StatusOr<EvidenceTerms> ParseEvidenceTerms(absl::string_view text);

}  // namespace egosieve::vision
