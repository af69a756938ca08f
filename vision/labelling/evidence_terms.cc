#include "vision/labelling/evidence_terms.h"

#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"

namespace egosieve::vision {
namespace {

using Term = std::pair<const char*, bool EvidenceTerms::*>;

const std::vector<Term>& Terms() {
  static const auto& terms =
      *new std::vector<Term>{{"epipolar", &EvidenceTerms::epipolar},
                             {"negative_depth", &EvidenceTerms::negative_depth},
                             {"road", &EvidenceTerms::road},
                             {"accumulation", &EvidenceTerms::accumulation}};
  return terms;
}

}  // namespace

std::string Describe(const EvidenceTerms& terms) {
  std::vector<std::string> names;
  for (const auto& [name, member] : Terms()) {
    if (terms.*member) names.push_back(name);
  }
  return names.size() == Terms().size() ? "all" : absl::StrJoin(names, ",");
}

absl::StatusOr<EvidenceTerms> ParseEvidenceTerms(absl::string_view text) {
  if (text == "all") return EvidenceTerms();
  EvidenceTerms terms{false, false, false, false};
  for (const absl::string_view word : absl::StrSplit(text, ',')) {
    bool known = false;
    for (const auto& [name, member] : Terms()) {
      if (word != name) continue;
      terms.*member = known = true;
    }
    if (!known) {
      return absl::InvalidArgumentError(
          absl::StrCat("'", word, "' is no evidence; give all, or a list of ",
                       absl::StrJoin(Terms(), ", ", [](std::string* out, const Term& term) {
                         absl::StrAppend(out, term.first);
                       })));
    }
  }
  if (!terms.IsEnough()) {
    return absl::InvalidArgumentError(
        absl::StrCat("'", text,
                     "' tells nothing of what moves; add epipolar, negative_depth "
                     "or road"));
  }
  return terms;
}

}  // namespace egosieve::vision
