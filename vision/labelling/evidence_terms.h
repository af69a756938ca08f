#ifndef EGOSIEVE_VISION_LABELLING_EVIDENCE_TERMS_H_
#define EGOSIEVE_VISION_LABELLING_EVIDENCE_TERMS_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::vision {

// What a label may rest on (vision/evidence).
struct EvidenceTerms {
  bool epipolar = true;        // distance to the motion model, whichever that is
  bool negative_depth = true;  // flow towards the point of expansion
  bool three_view = true;      // a depth that does not last
  bool road = true;            // below the road, or standing on it elsewhere than its depth says
  bool accumulation = true;    // memory along tracks
  bool own_vehicle = true;     // parts of the image that stand still while the world moves

  static EvidenceTerms EpipolarAlone() { return {true, false, false, false, false, false}; }

  bool IsEpipolarAlone() const {
    return epipolar && !negative_depth && !three_view && !road && !accumulation && !own_vehicle;
  }
  // Something says what moves; the last two only add to it.
  bool IsEnough() const { return epipolar || negative_depth || three_view || road; }
};

// "all", or the fields' names in their order, joined by commas.
std::string Describe(const EvidenceTerms& terms);
// InvalidArgument, listing the names, for what Describe cannot have written; any order is read.
absl::StatusOr<EvidenceTerms> ParseEvidenceTerms(absl::string_view text);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_EVIDENCE_TERMS_H_
