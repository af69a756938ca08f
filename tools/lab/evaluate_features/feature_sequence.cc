#include "tools/lab/evaluate_features/feature_sequence.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluate/truth_masks.h"
#include "tools/suite/sequences.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {
namespace {

// The truth of a synthetic drive is its folder; returns its masks.
std::string MasksOrTracks(const Sequence& sequence) {
  std::error_code error;
  const std::filesystem::path masks = std::filesystem::path(sequence.truth) / "masks";
  return std::filesystem::is_directory(masks, error) ? masks.string() : sequence.truth;
}

// The number at the end of a frame's name; 0 if there is none.
int64_t NumberOf(const std::string& name) {
  const size_t last = name.find_last_not_of("0123456789");
  int64_t number = 0;
  return absl::SimpleAtoi(last == std::string::npos ? name : name.substr(last + 1), &number)
             ? number
             : 0;
}

}  // namespace

absl::StatusOr<std::vector<FeatureSequence>> FindFeatureSequences(const std::string& folder) {
  EGOSIEVE_ASSIGN_OR_RETURN(const SequenceList list, FindSequences(folder));
  std::vector<FeatureSequence> sequences;
  for (const Sequence& sequence : list.sequences) {
    sequences.push_back({sequence.name, sequence.frames, MasksOrTracks(sequence)});
  }
  std::sort(sequences.begin(), sequences.end(),
            [](const FeatureSequence& a, const FeatureSequence& b) {
              return vision::NaturalLess(a.name, b.name);
            });
  return sequences;
}

absl::StatusOr<FeatureTruth> ReadFeatureTruth(const FeatureSequence& sequence) {
  FeatureTruth truth;
  const std::vector<std::string> names = FrameNames(sequence.frames);
  if (absl::EndsWith(sequence.truth, ".csv")) {
    const int64_t first_number = names.empty() ? 0 : NumberOf(names.front());
    EGOSIEVE_ASSIGN_OR_RETURN(truth.tracks,
                              vision::ReadLabelledTracks(sequence.truth, first_number));
    if (truth.tracks.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat(sequence.truth, ": there is no track in it"));
    }
    return truth;
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const TruthMasks masks,
                            ListTruthMasks(sequence.truth, names, MatchMasks::kAuto));
  truth.masks = masks.paths;
  return truth;
}

}  // namespace egosieve::tools
